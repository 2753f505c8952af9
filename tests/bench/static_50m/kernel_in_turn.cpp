#include "tests/bench/static_50m/kernel_in_turn.h"

#include "passes/matching/kernel/portable_vectors.h"
#include "passes/matching/kernel_score.h"
#include "tests/bench/static_50m/in_turn.h"

namespace sightline {

KernelVersion kernel_in_turn() {
  switch (fastest_kernel()) {
#ifdef SIGHTLINE_X86_KERNELS
    case MatchKernel::kAvx2:
      return in_turn_avx2();
    case MatchKernel::kAvx512:
      return in_turn_avx512();
#endif
    default:
      return kernel_of<Portable, InTurn>();
  }
}

}  // namespace sightline
