#pragma once

#include <ctime>

namespace sightline {

// For reports only: no time ever enters the map.
inline double clock_ms(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

// CPU time of the calling thread, and of all threads of the program, ms.
inline double thread_cpu_ms() { return clock_ms(CLOCK_THREAD_CPUTIME_ID); }
inline double process_cpu_ms() { return clock_ms(CLOCK_PROCESS_CPUTIME_ID); }

}  // namespace sightline
