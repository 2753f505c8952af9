#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "passes/model/forest/growing/tree_rows.h"

namespace sightline {

// Rows of a node: places [begin, end) in the orders.
struct Part {
  double label_sum = 0.0;
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size = 0;    // of samples, with all copies
  std::uint32_t sure = 0;  // a feature in whose order they stand there for certain
  std::uint32_t node = 0;

  [[nodiscard]] float mean() const {
    return static_cast<float>(label_sum / static_cast<double>(size));
  }
};

struct Split {
  double score = -1.0;  // of both sides, the squared sum of labels by their number; below any: none
  double left_sum = 0.0;
  std::size_t left_size = 0;
  std::size_t at = 0;                       // where the right side begins
  std::uint32_t feature = TreeRows::kNone;  // kNone: no feature distinguishes rows
};

// The split of the highest score by one of these features, between rows that it distinguishes. Of
// equal ones the first feature's, of one feature the first in its order.
Split best_split(const TreeRows& rows, const Part& part, std::span<const std::uint32_t> features);

}  // namespace sightline
