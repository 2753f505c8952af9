#include "passes/matching/kernel/avx2_vectors.h"
#include "tests/bench/static_50m/in_turn.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

namespace sightline {

KernelVersion in_turn_avx2() { return kernel_of<Avx2, InTurn>(); }

}  // namespace sightline
