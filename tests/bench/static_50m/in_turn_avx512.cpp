#include "passes/matching/kernel/avx512_vectors.h"
#include "tests/bench/static_50m/in_turn.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

namespace sightline {

KernelVersion in_turn_avx512() { return kernel_of<Avx512, InTurn>(); }

}  // namespace sightline
