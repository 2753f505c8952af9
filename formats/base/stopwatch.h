#pragma once

#include <ctime>

namespace sightline {

// CPU time of the calling thread, ms. For reports only: no time ever enters the map.
inline double thread_cpu_ms() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

}  // namespace sightline
