#pragma once

#include "passes/matching/kernel/match_kernel_body.h"

namespace sightline {
namespace {

// An order for kernel_of(): the records of a batch's last cells are asked for while the batch
// before it is computed; what changed since comes from memory when it is needed.
struct InTurn {
  template <class B, class Use>
  static void for_batches(const KernelInput& in, const Use& use) {
    for (std::size_t first = 0; first < in.count; first += kKernelBatch) {
      BatchPoints points;
      find_records(in, first, locate_batch<B>(in, first, points));
      if (first + kKernelBatch < in.count) fetch_records(in, first + kKernelBatch);
      use(first, points);
    }
  }
};

}  // namespace
}  // namespace sightline
