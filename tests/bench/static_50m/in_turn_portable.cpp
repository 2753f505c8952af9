#include "passes/matching/kernel/portable_vectors.h"
#include "tests/bench/static_50m/in_turn.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

namespace sightline {

KernelVersion in_turn_portable() { return kernel_of<Portable, InTurn>(); }

}  // namespace sightline
