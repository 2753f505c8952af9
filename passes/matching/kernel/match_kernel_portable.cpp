#include "passes/matching/kernel/match_kernel_body.h"
#include "passes/matching/kernel/portable_vectors.h"

namespace sightline {

KernelVersion kernel_portable() { return kernel_of<Portable, Ahead>(); }

}  // namespace sightline
