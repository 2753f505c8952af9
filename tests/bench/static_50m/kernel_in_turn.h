#pragma once

#include "passes/matching/kernel/match_kernel.h"

namespace sightline {

// The kernel as it was: a batch is located, then computed, one after the other. The same bits. Of
// the instructions that fastest_kernel() names.
KernelVersion kernel_in_turn();

#ifdef SIGHTLINE_X86_KERNELS
KernelVersion in_turn_avx2();
KernelVersion in_turn_avx512();
#endif

}  // namespace sightline
