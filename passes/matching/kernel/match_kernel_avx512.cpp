#include "passes/matching/kernel/avx512_vectors.h"
#include "passes/matching/kernel/match_kernel_body.h"

namespace sightline {

KernelVersion kernel_avx512() { return kernel_of<Avx512, Ahead>(); }

}  // namespace sightline
