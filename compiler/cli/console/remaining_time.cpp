#include "compiler/cli/console/remaining_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sightline {

void RemainingTime::finish(const StepReport& report) {
  if (step_ >= expected_s_.size() || report.from_cache) return;
  taken_s_ += report.wall_s;
  foreseen_s_ += expected_s_[step_];
}

std::optional<double> RemainingTime::of_run_s(double step_left_s) const {
  if (step_ >= expected_s_.size()) return std::nullopt;
  double later_s = 0.0;
  for (std::size_t i = step_ + 1; i < expected_s_.size(); ++i) later_s += expected_s_[i];
  constexpr double kEnough_s = 2.0;  // to tell this machine from the one that was measured
  const bool is_known = foreseen_s_ > kEnough_s;
  return step_left_s + later_s * (is_known ? std::clamp(taken_s_ / foreseen_s_, 0.1, 10.0) : 1.0);
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
