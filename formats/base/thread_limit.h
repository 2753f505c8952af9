#pragma once

#include <memory>

namespace sightline {

// The threads that this process uses where no number is given: one for each processor of its
// affinity, at most the quota of its control groups (formats/base/machine.h), at most what the
// system starts (a limit of processes, an old container runtime); the limit below, where there is
// one. At least one. Counted once, when first used.
int usable_threads();

// While it exists the whole process, with the libraries that bring tasks of their own (Embree),
// works on at most so many threads; 0: usable_threads().
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Control;
  std::unique_ptr<Control> control_;
};

}  // namespace sightline
