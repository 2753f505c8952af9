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
#include "formats/text/json_text.h"

namespace sightline {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

double rounded(double seconds) { return std::round(seconds * 1000.0) / 1000.0; }

class JsonLines {
 public:
  JsonLines(int descriptor, std::vector<ExpectedTime> expected)
      : descriptor_(descriptor), remaining_(std::move(expected)) {}

  void start(std::size_t step, std::size_t steps, const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    pass_ = {{"pass", name}, {"step", step + 1}, {"steps", steps}};
    remaining_.start(step);
    begin_ = Clock::now();
    reported_ = {};
    reported_done_ = 0;
    write("started", {});
  }
  void update(std::size_t done, std::size_t total) {
    constexpr auto kPause = std::chrono::milliseconds(200);
    const std::lock_guard<std::mutex> lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (done < reported_done_) return;  // a thread that counted earlier and came later
    if (done < total && now - reported_ < kPause) return;
    reported_ = now;
    reported_done_ = done;
    const double elapsed_s = std::chrono::duration<double>(now - begin_).count();
    Json rest = {{"done", done}, {"total", total}, {"elapsed_s", rounded(elapsed_s)}};
    if (done > 0) {
      const double left_s = remaining_.of_step_s(elapsed_s, done, total);
      rest["remaining_s"] = rounded(left_s);
      if (const std::optional<double> run_s = remaining_.of_run_s(left_s, elapsed_s)) {
        rest["run_remaining_s"] = rounded(*run_s);
      }
    }
    write("progress", rest);
  }
  // `event`: "warning" or "information".
  void say(const char* event, const std::string& pass, const std::string& message) {
    const std::lock_guard<std::mutex> lock(mutex_);
    put({{"event", event}, {"pass", pass}, {"message", message}});
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
    const std::string text = json_text(line, -1) + "\n";
    is_broken_ = ::write(descriptor_, text.data(), text.size()) < 0;
  }

  const int descriptor_;
  std::mutex mutex_;
  RemainingTime remaining_;
  Json pass_ = Json::object();
  Clock::time_point begin_;
  Clock::time_point reported_;
  std::size_t reported_done_ = 0;
  bool is_broken_ = false;
};

}  // namespace

RunObserver json_observer(int descriptor, std::vector<ExpectedTime> expected) {
  std::signal(SIGPIPE, SIG_IGN);
  const auto lines = std::make_shared<JsonLines>(descriptor, std::move(expected));
  RunObserver observer;
  observer.started = [lines](std::size_t step, std::size_t steps, const std::string& name) {
    lines->start(step, steps, name);
  };
  observer.progress = [lines](std::size_t done, std::size_t total) { lines->update(done, total); };
  observer.warning = [lines](const std::string& pass, const std::string& message) {
    lines->say("warning", pass, message);
  };
  observer.information = [lines](const std::string& pass, const std::string& message) {
    lines->say("information", pass, message);
  };
  observer.finished = [lines](const StepReport& report) { lines->finish(report); };
  return observer;
}

Result<void> check_progress_descriptor(int descriptor) {
  const int mode = ::fcntl(descriptor, F_GETFL);
  if (mode >= 0 && (mode & O_ACCMODE) != O_RDONLY) return {};
  return Error{ErrorCode::kBadArgument,
               concat("file descriptor ", descriptor, " is not open for writing"), "",
               "--json-progress"};
}

}  // namespace sightline
