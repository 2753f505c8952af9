#include "compiler/cli/console/remaining_time.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// Measured and expected speed of this machine have the same weight after so much expected time.
constexpr double kWeight_s = 1.0;

}  // namespace

double RemainingTime::slowness() const {
  return (taken_s_ + kWeight_s) / (foreseen_s_ + kWeight_s);
}

void RemainingTime::finish(const StepReport& report) {
  if (step_ >= expected_s_.size() || report.from_cache) return;
  taken_s_ += report.wall_s;
  foreseen_s_ += expected_s_[step_];
}

double RemainingTime::of_step_s(double elapsed_s, std::size_t done, std::size_t total) const {
  constexpr double kMisjudged = 3.0;  // by how much an expectation may be wrong
  const double left_s = seconds_left(elapsed_s, done, total);
  if (step_ >= expected_s_.size() || done == total) return left_s;
  const double expected_s = expected_s_[step_] * slowness();
  const bool is_all_counted = kMisjudged * (elapsed_s + left_s) >= expected_s;
  return is_all_counted ? left_s : expected_s - elapsed_s;
}

std::optional<double> RemainingTime::of_run_s(double step_left_s, double elapsed_s) const {
  if (step_ >= expected_s_.size()) return std::nullopt;
  double later_s = 0.0;
  for (std::size_t i = step_ + 1; i < expected_s_.size(); ++i) later_s += expected_s_[i];
  const double step_s = elapsed_s + step_left_s;
  const double foreseen_s =
      foreseen_s_ + (step_s > 0.0 ? expected_s_[step_] * elapsed_s / step_s : 0.0);
  const double slower = (taken_s_ + elapsed_s + kWeight_s) / (foreseen_s + kWeight_s);
  return step_left_s + later_s * std::clamp(slower, 0.1, 10.0);
}

double seconds_left(double elapsed_s, std::size_t done, std::size_t total) {
  const double share = static_cast<double>(done) / static_cast<double>(total);
  return elapsed_s * (1.0 - share) / share;
}

std::string clock_text(double seconds) {
  const int whole = static_cast<int>(std::lround(seconds));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

}  // namespace sightline
