// Preloaded into a program, makes the clock of the day jump by up to ten years, back and forth, at
// each call. The clocks that only go forward are left alone.

#include <dlfcn.h>
#include <sys/time.h>

#include <atomic>
#include <ctime>

namespace {

// s, from -5 to 5 years.
time_t jump() {
  static std::atomic<unsigned> calls = 0;
  constexpr unsigned kTenYears_s = 315'360'000;
  const unsigned scattered = (calls++ + 1U) * 2'654'435'761U;
  return static_cast<time_t>(scattered % kTenYears_s) - kTenYears_s / 2;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  static const auto call =
      reinterpret_cast<int (*)(clockid_t, timespec*)>(::dlsym(RTLD_NEXT, "clock_gettime"));
  const int result = call(clock, now);
  if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += jump();
  return result;
}
int gettimeofday(timeval* now, void* /*zone*/) noexcept {
  timespec precise{};
  const int result = clock_gettime(CLOCK_REALTIME, &precise);
  now->tv_sec = precise.tv_sec;
  now->tv_usec = precise.tv_nsec / 1000;
  return result;
}
time_t time(time_t* now) noexcept {
  timespec precise{};
  clock_gettime(CLOCK_REALTIME, &precise);
  if (now != nullptr) *now = precise.tv_sec;
  return precise.tv_sec;
}

}  // extern "C"
