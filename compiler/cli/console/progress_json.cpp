#include "compiler/cli/console/progress_json.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "compiler/cli/console/console.h"

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double rounded(double seconds) { return std::round(seconds * 1000.0) / 1000.0; }

class JsonLines {
 public:
  JsonLines(int descriptor, std::vector<double> expected_s)
      : descriptor_(descriptor), remaining_(std::move(expected_s)) {}

  void start(std::size_t step, std::size_t steps, const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    pass_ = {{"pass", name}, {"step", step + 1}, {"steps", steps}};
    remaining_.start(step);
    begin_ = Clock::now();
    told_ = {};
    told_done_ = 0;
    write("started", {});
  }
  void update(std::size_t done, std::size_t total) {
    constexpr auto kPause = std::chrono::milliseconds(200);
    const std::lock_guard<std::mutex> lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (done < told_done_) return;  // a thread that counted earlier and came later
    if (done < total && now - told_ < kPause) return;
    told_ = now;
    told_done_ = done;
    const double elapsed_s = std::chrono::duration<double>(now - begin_).count();
    Json rest = {{"done", done}, {"total", total}, {"elapsed_s", rounded(elapsed_s)}};
    if (done > 0) {
      const double left_s = seconds_left(elapsed_s, done, total);
      rest["remaining_s"] = rounded(left_s);
      if (const std::optional<double> run_s = remaining_.of_run_s(left_s)) {
        rest["run_remaining_s"] = rounded(*run_s);
      }
    }
    write("progress", rest);
  }
  void warn(const std::string& pass, const std::string& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    put({{"event", "warning"}, {"pass", pass}, {"message", message}});
  }
  void finish(const StepReport& report) {
    const std::lock_guard<std::mutex> lock(mutex_);
    remaining_.finish(report);
    write("finished", {{"wall_s", rounded(report.wall_s)},
                       {"cpu_s", rounded(report.cpu_s)},
                       {"peak_memory_mib", std::round(report.peak_memory_mib)},
                       {"from_cache", report.from_cache}});
  }

 private:
  void write(const char* event, const Json& rest) {
    Json line = {{"event", event}};
    line.update(pass_);
    if (!rest.is_null()) line.update(rest);
    put(line);
  }
  void put(const Json& line) {
    if (is_broken_) return;
    // A name that is no UTF-8 must not end the run.
    const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    is_broken_ = ::write(descriptor_, text.data(), text.size()) < 0;
  }

  const int descriptor_;
  std::mutex mutex_;
  RemainingTime remaining_;
  Json pass_ = Json::object();
  Clock::time_point begin_;
  Clock::time_point told_;
  std::size_t told_done_ = 0;
  bool is_broken_ = false;
};

template <class... Arguments>
std::function<void(Arguments...)> both(std::function<void(Arguments...)> first,
                                       std::function<void(Arguments...)> second) {
  return [first = std::move(first), second = std::move(second)](Arguments... arguments) {
    if (first) first(arguments...);
    if (second) second(arguments...);
  };
}

}  // namespace

RunObserver json_observer(int descriptor, std::vector<double> expected_s) {
  std::signal(SIGPIPE, SIG_IGN);
  const auto lines = std::make_shared<JsonLines>(descriptor, std::move(expected_s));
  RunObserver observer;
  observer.started = [lines](std::size_t step, std::size_t steps, const std::string& name) {
    lines->start(step, steps, name);
  };
  observer.progress = [lines](std::size_t done, std::size_t total) { lines->update(done, total); };
  observer.warning = [lines](const std::string& pass, const std::string& message) {
    lines->warn(pass, message);
  };
  observer.finished = [lines](const StepReport& report) { lines->finish(report); };
  return observer;
}

Result<void> check_progress_descriptor(int descriptor) {
  const int mode = ::fcntl(descriptor, F_GETFL);
  if (mode >= 0 && (mode & O_ACCMODE) != O_RDONLY) return {};
  return Error{ErrorCode::kBadArgument,
               "file descriptor " + std::to_string(descriptor) + " is not open for writing", "",
               "--json-progress"};
}

RunObserver both(RunObserver first, RunObserver second) {
  RunObserver observer;
  observer.started = both(std::move(first.started), std::move(second.started));
  observer.progress = both(std::move(first.progress), std::move(second.progress));
  observer.warning = both(std::move(first.warning), std::move(second.warning));
  observer.finished = both(std::move(first.finished), std::move(second.finished));
  observer.printed = both(std::move(first.printed), std::move(second.printed));
  return observer;
}

}  // namespace sightline
