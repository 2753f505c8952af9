// The wheel's libraries run with the libstdc++ of GCC 11 (GLIBCXX_3.4.29, that of manylinux_2_34).
// GCC 12 gave this function another version, so programs that call it need its own library. Here it
// is for the wheel alone, hidden.
#include <condition_variable>
#include <mutex>

void std::condition_variable::wait(std::unique_lock<std::mutex>& lock) {
  _M_cond.wait(*lock.mutex());
}
