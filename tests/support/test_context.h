#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "passes/pass/pass_context.h"
#include "tests/support/value_of.h"

namespace sightline {

// The context of a run of a pass; it keeps warnings and information alike. Write
// `some_pass(TestContext(), ...)` where they do not matter.
class TestContext {
 public:
  explicit TestContext(int threads = 1) {
    ctx_.threads = threads;
    ctx_.warning_sink = [this](const std::string& message) {
      const std::lock_guard<std::mutex> lock(mutex_);
      warnings.push_back(message);
    };
    ctx_.information_sink = ctx_.warning_sink;
  }
  TestContext(const TestContext&) = delete;
  TestContext& operator=(const TestContext&) = delete;
  operator PassContext&() { return ctx_; }  // NOLINT: implicit

  std::vector<std::string> warnings;

 private:
  std::mutex mutex_;
  PassContext ctx_;
};

}  // namespace sightline
