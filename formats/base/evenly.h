#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace sightline {

// Positions of `most` of so many things, or of all where they are fewer: each in the middle of one
// of equal stretches; ascending.
inline std::vector<std::size_t> evenly(std::size_t size, std::size_t most) {
  const std::size_t count = std::min(size, most);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back((2 * i + 1) * size / (2 * count));
  return chosen;
}

}  // namespace sightline
