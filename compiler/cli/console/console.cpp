#include "compiler/cli/console/console.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <system_error>
#include <thread>
#include <utility>

#include "formats/base/printable.h"

namespace sightline {
namespace {

// Whether the file descriptor is a terminal that moves its cursor and has colours: one whose kind
// (TERM) is not known can only print lines.
bool is_able_terminal(int descriptor) {
  const char* const kind = std::getenv("TERM");
  const std::string_view name = kind == nullptr ? "" : kind;
  return !name.empty() && name != "dumb" && ::isatty(descriptor) == 1;
}

// Whether text on this file descriptor may have colours: such a terminal, and NO_COLOR is absent or
// empty (no-color.org).
bool allows_color(int descriptor) {
  const char* const no_color = std::getenv("NO_COLOR");
  const bool is_forbidden = no_color != nullptr && no_color[0] != '\0';
  return !is_forbidden && is_able_terminal(descriptor);
}

// In the order of Tone, and what ends each.
constexpr std::array<std::string_view, 5> kTones = {"\033[32m", "\033[31m", "\033[33m", "\033[1m",
                                                    "\033[90m"};
constexpr std::string_view kToneEnds = "\033[0m";

// The length of a tone's beginning or end at the front of a text; 0: there is none.
std::size_t tone_length(std::string_view text) {
  if (text.starts_with(kToneEnds)) return kToneEnds.size();
  for (const std::string_view tone : kTones) {
    if (text.starts_with(tone)) return tone.size();
  }
  return 0;
}

// printable() of the text between tones.
std::string printable_between_tones(std::string_view text) {
  std::string shown;
  std::size_t begin = 0;
  for (std::size_t at = text.find('\033'); at != std::string_view::npos;) {
    const std::size_t length = tone_length(text.substr(at));
    if (length > 0) {
      shown += printable(text.substr(begin, at - begin));
      shown += text.substr(at, length);
      begin = at + length;
    }
    at = text.find('\033', at + std::max<std::size_t>(length, 1));
  }
  return shown + printable(text.substr(begin));
}

std::atomic<Verbosity> g_verbosity = Verbosity::kNormal;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Columns of the terminal; a line that wraps could not be wiped.
std::size_t terminal_width() {
  winsize size{};
  const bool is_known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : 80;
}

std::shared_ptr<spdlog::logger> logger() {
  static const std::shared_ptr<spdlog::logger> kLogger = [] {
    const spdlog::color_mode mode =
        allows_color(STDERR_FILENO) ? spdlog::color_mode::automatic : spdlog::color_mode::never;
    std::shared_ptr<spdlog::logger> made = spdlog::stderr_color_mt("sightline", mode);
    made->set_pattern("%^%l%$ %v");
    return made;
  }();
  return kLogger;
}

enum class ProgressForm { kNone, kMovingLine, kLines };

// On a terminal a moving line, redrawn at most ten times a second and wiped before anything else is
// printed; else, in a log, a line of its own now and then. A thread draws it where a pass reports
// nothing for long, so that no long pass is silent.
class ProgressLine {
 public:
  ProgressLine(ProgressForm form, double line_every_s, std::vector<ExpectedTime> expected)
      : form_(form),
        pause_s_(form == ProgressForm::kLines ? line_every_s : 0.1),
        remaining_(std::move(expected)) {
    if (form == ProgressForm::kNone) return;
    try {
      draw_when_silent(std::max(pause_s_, form == ProgressForm::kLines ? 0.1 : 1.0));
    } catch (const std::system_error&) {
      // The system starts no thread: then only what passes report is drawn.
    }
  }

  void start(std::size_t step, std::size_t steps, const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    head_ = fmt::format("[{}/{}] {}", step + 1, steps, name);
    done_ = total_ = 0;
    remaining_.start(step);
    begin_ = drawn_ = Clock::now();
    draw(head_);
  }

  void update(std::size_t done, std::size_t total) {
    if (form_ == ProgressForm::kNone || total == 0) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = done;
    total_ = total;
    if (seconds_since(drawn_) >= pause_s_) show();
  }

  void finish(const StepReport& report) {
    const std::lock_guard<std::mutex> lock(mutex_);
    draw("");
    head_.clear();
    remaining_.finish(report);
  }

  void wipe() {
    const std::lock_guard<std::mutex> lock(mutex_);
    draw("");
  }

 private:
  void draw_when_silent(double silence_s) {
    drawing_ = std::jthread([this, silence_s](const std::stop_token& stop) {
      std::unique_lock<std::mutex> lock(mutex_);
      while (!ended_.wait_for(lock, stop, std::chrono::duration<double>(silence_s),
                              [&] { return stop.stop_requested(); })) {
        if (!head_.empty() && seconds_since(drawn_) >= silence_s) show();
      }
    });
  }

  // With the share done and the time that remains; without a count, the time so far.
  void show() {
    drawn_ = Clock::now();
    const double elapsed_s = seconds_since(begin_);
    std::string line = head_;
    if (total_ > 0) line += concat("  ", done_, "/", total_);
    if (done_ == 0) line += concat("  ", clock_text(elapsed_s), " so far");
    if (done_ > 0) {
      const double left_s = remaining_.of_step_s(elapsed_s, done_, total_);
      line += concat("  ", clock_text(left_s), " left");
      const std::optional<double> run_s = remaining_.of_run_s(left_s, elapsed_s);
      if (run_s && *run_s > left_s) line += concat(", ", clock_text(*run_s), " of the whole run");
    }
    if (form_ == ProgressForm::kLines) return logger()->info("{}", line);
    draw(line);
  }

  void draw(const std::string& line) const {
    if (form_ != ProgressForm::kMovingLine) return;
    std::fprintf(stderr, "\r\033[K%s", line.substr(0, terminal_width() - 1).c_str());
  }

  const ProgressForm form_;
  const double pause_s_;  // between two lines
  std::mutex mutex_;
  RemainingTime remaining_;
  std::string head_;      // of the present step; empty: none runs
  std::size_t done_ = 0;  // of it
  std::size_t total_ = 0;
  Clock::time_point begin_;
  Clock::time_point drawn_;
  std::condition_variable_any ended_;
  std::jthread drawing_;  // last: it uses the others
};

// Where the output of a step comes from.
std::string_view origin(const StepReport& report) {
  if (!report.from_cache) return "done";
  return report.reason == kNotNeeded ? kNotNeeded : "from the cache";
}

// Prints what is kept. Ctrl-C ends the program by the signal, so that a shell ends its loop; at
// SIGTERM of a scheduler it exits as incomplete, so that the scheduler starts it again.
template <bool kHasCache>
void on_interrupt(int signal) {
  constexpr std::string_view kText =
      kHasCache ? "\nSL7001 interrupted: finished passes are in the cache; the same command "
                  "continues from there\n"
                : "\nSL7001 interrupted: nothing is kept without a cache; leave out --no-cache to "
                  "continue from finished passes\n";
  (void)!::write(STDERR_FILENO, kText.data(), kText.size());
  if (signal == SIGTERM) ::_exit(exit_status(ErrorCode::kInterrupted));
  (void)std::signal(signal, SIG_DFL);
  (void)::raise(signal);  // comes when this handler has returned
}

template <class... Arguments>
std::function<void(Arguments...)> both(std::function<void(Arguments...)> first,
                                       std::function<void(Arguments...)> second) {
  return [first = std::move(first), second = std::move(second)](Arguments... arguments) {
    if (first) first(arguments...);
    if (second) second(arguments...);
  };
}

}  // namespace

RunObserver console_observer(Verbosity verbosity, std::vector<ExpectedTime> expected,
                             double line_every_s) {
  const bool is_quiet = verbosity == Verbosity::kQuiet;
  const bool is_verbose = verbosity == Verbosity::kVerbose;
  const ProgressForm form = is_quiet                          ? ProgressForm::kNone
                            : is_able_terminal(STDERR_FILENO) ? ProgressForm::kMovingLine
                                                              : ProgressForm::kLines;
  const auto line = std::make_shared<ProgressLine>(form, line_every_s, std::move(expected));
  RunObserver observer;
  observer.started = [line, is_verbose](std::size_t step, std::size_t steps,
                                        const std::string& name) {
    if (is_verbose) logger()->info("{} starts, {} of {}", name, step + 1, steps);
    line->start(step, steps, name);
  };
  observer.progress = [line](std::size_t done, std::size_t total) { line->update(done, total); };
  observer.warning = [line](const std::string& pass, const std::string& message) {
    line->wipe();
    logger()->warn("{}: {}", pass, log_text(message));
  };
  observer.information = [line, is_quiet](const std::string& pass, const std::string& message) {
    if (is_quiet) return;
    line->wipe();
    logger()->info("{}: {}", pass, log_text(message));
  };
  observer.finished = [line, is_quiet, is_verbose](const StepReport& report) {
    line->finish(report);
    if (is_quiet) return;
    const std::string cost = fmt::format(": {}; {:.1f} s of processor time, {:.0f} MiB at most",
                                         report.reason, report.cpu_s, report.peak_memory_mib);
    logger()->info("{:<28} {:>7.1f} s  {}{}", report.name, report.wall_s, origin(report),
                   is_verbose ? cost : "");
  };
  observer.printed = [line](const std::string& /*pass*/, const Table& table) {
    line->wipe();
    print_data(format_table(table, TableFormat::kCsv));
  };
  return observer;
}

void set_verbosity(Verbosity verbosity) { g_verbosity = verbosity; }

Verbosity verbosity() { return g_verbosity; }

std::string toned(Tone tone, std::string_view text) {
  if (!allows_color(STDOUT_FILENO)) return std::string(text);
  return concat(kTones[static_cast<std::size_t>(tone)], printable(text), kToneEnds);
}

void print_note(const std::string& line) {
  if (verbosity() == Verbosity::kQuiet) return;
  std::fputs((log_text(line) + "\n").c_str(), stderr);
}

void print_warning(const std::string& text) { logger()->warn("{}", log_text(text)); }

void log_cost(const std::string& command, double wall_s) {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  logger()->info("{} took {:.2f} s and {:.0f} MiB of memory", command, wall_s,
                 static_cast<double>(used.ru_maxrss) / 1024.0);
}

void print_text(std::string_view text) {
  const bool has_tones = allows_color(STDOUT_FILENO);
  const std::string shown = has_tones ? printable_between_tones(text) : log_text(text);
  (void)std::fwrite(shown.data(), 1, shown.size(), stdout);
}

void print_data(std::string_view data) {
  if (::isatty(STDOUT_FILENO) == 1) return print_text(data);
  (void)std::fwrite(data.data(), 1, data.size(), stdout);
}

int report_error(const Error& error) {
  Error shown = error;
  shown.file = one_line(error.file);
  logger()->error("{}", log_text(to_string(shown)));
  return exit_status(error.code);
}

std::string time_table(const std::vector<StepReport>& reports) {
  std::string text = "pass                            wall s    cpu s   peak MiB\n";
  double wall_s = 0.0;
  double cpu_s = 0.0;
  for (const StepReport& report : reports) {
    text += fmt::format("{:28} {:>9.2f} {:>8.2f} {:>10.0f}", report.name, report.wall_s,
                        report.cpu_s, report.peak_memory_mib);
    text += report.from_cache ? concat("  (", origin(report), ")\n") : "\n";
    wall_s += report.wall_s;
    cpu_s += report.cpu_s;
  }
  return text + fmt::format("{:28} {:>9.2f} {:>8.2f}\n", "all", wall_s, cpu_s);
}

std::string explanation(const std::vector<StepReport>& reports) {
  std::string text;
  for (const StepReport& report : reports) {
    text +=
        concat((report.from_cache ? "kept  " : "ran   "), report.name, ": ", report.reason, "\n");
  }
  return text;
}

void explain_interruption(bool has_cache) {
  const auto handler = has_cache ? &on_interrupt<true> : &on_interrupt<false>;
  for (const int signal : {SIGINT, SIGTERM}) {
    // What the caller ignores stays ignored, as with nohup and in the background of a script.
    if (std::signal(signal, SIG_IGN) != SIG_IGN) std::signal(signal, handler);
  }
}

RunObserver both(RunObserver first, RunObserver second) {
  RunObserver observer;
  observer.started = both(std::move(first.started), std::move(second.started));
  observer.progress = both(std::move(first.progress), std::move(second.progress));
  observer.warning = both(std::move(first.warning), std::move(second.warning));
  observer.information = both(std::move(first.information), std::move(second.information));
  observer.finished = both(std::move(first.finished), std::move(second.finished));
  observer.printed = both(std::move(first.printed), std::move(second.printed));
  return observer;
}

}  // namespace sightline
