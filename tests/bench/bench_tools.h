#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <vector>

namespace sightline {

inline double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Pushes scan, map and tables out of the caches, as other work on a vehicle does between two scans.
inline void empty_caches() {
  static std::vector<char> memory(std::size_t{64} << 20);
  static char value = 0;
  std::memset(memory.data(), ++value, memory.size());
}

struct Share {
  std::uint64_t all = 0;
  std::uint64_t chosen = 0;
  void count(bool is_chosen) {
    ++all;
    chosen += is_chosen ? 1 : 0;
  }
  [[nodiscard]] double percent(double of_none) const {
    return all == 0 ? of_none : 100.0 * static_cast<double>(chosen) / static_cast<double>(all);
  }
};

}  // namespace sightline
