#include "passes/matching/kernel/avx2_vectors.h"
#include "passes/matching/kernel/match_kernel_body.h"

namespace sightline {

KernelVersion kernel_avx2() { return kernel_of<Avx2, Ahead>(); }

}  // namespace sightline
