#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

namespace sightline {

// Pushes scan, map and tables out of the caches, as other work on a vehicle does between two scans.
inline void empty_caches() {
  static std::vector<char> memory(std::size_t{64} << 20);
  static char value = 0;
  std::memset(memory.data(), ++value, memory.size());
}

}  // namespace sightline
