#pragma once

#include <cstdint>
#include <vector>

namespace sightline {

// Which rows to learn, and what: labels[i] belongs to features.row(rows[i]).
struct LabelledRows {
  std::vector<std::uint32_t> rows;
  std::vector<double> labels;
};

}  // namespace sightline
