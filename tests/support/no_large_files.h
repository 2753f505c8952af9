#pragma once

#include <sys/resource.h>

#include <csignal>

#include "formats/base/check.h"

namespace sightline {

// While it lives no file grows beyond a kilobyte, as on a full disk.
class NoLargeFiles {
 public:
  NoLargeFiles() {
    SIGHTLINE_CHECK(::getrlimit(RLIMIT_FSIZE, &before_) == 0);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    rlimit small = before_;
    small.rlim_cur = 1000;
    SIGHTLINE_CHECK(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  }
  NoLargeFiles(const NoLargeFiles&) = delete;
  NoLargeFiles& operator=(const NoLargeFiles&) = delete;
  ~NoLargeFiles() {
    (void)::setrlimit(RLIMIT_FSIZE, &before_);
    (void)std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

}  // namespace sightline
