#include "compiler/cli/console/remaining_time.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace sightline {

RemainingTime::RemainingTime(std::vector<ExpectedTime> expected) : expected_(std::move(expected)) {
  constexpr double kLeastTrust_s = 1.0;
  constexpr double kTrustedShare = 0.05;  // of the whole run
  double all_s = 0.0;
  for (const ExpectedTime& step : expected_) all_s += step.wall_s;
  trust_s_ = std::max(kLeastTrust_s, kTrustedShare * all_s);
}

double RemainingTime::slowness() const { return (taken_s_ + trust_s_) / (foreseen_s_ + trust_s_); }

void RemainingTime::finish(const StepReport& report) {
  if (step_ >= expected_.size() || report.from_cache) return;
  taken_s_ += report.wall_s;
  foreseen_s_ += expected_[step_].wall_s;
}

double RemainingTime::of_step_s(double elapsed_s, std::size_t done, std::size_t total) {
  if (step_ >= expected_.size()) return seconds_left(elapsed_s, done, total);
  const double share = static_cast<double>(done) / static_cast<double>(total);
  if (done < total) all_counted_s_.reset();
  if (done == total && !all_counted_s_) all_counted_s_ = elapsed_s;
  const double counted_s = all_counted_s_.value_or(elapsed_s / share) / expected_[step_].counted;
  const double expected_s = expected_[step_].wall_s * slowness();
  const double trust =
      elapsed_s < expected_s ? std::max(share, elapsed_s / expected_s) : 1.0;  // in the count
  return std::max(0.0, (1.0 - trust) * expected_s + trust * counted_s - elapsed_s);
}

std::optional<double> RemainingTime::of_run_s(double step_left_s, double elapsed_s) const {
  if (step_ >= expected_.size()) return std::nullopt;
  double later_s = 0.0;
  for (std::size_t i = step_ + 1; i < expected_.size(); ++i) later_s += expected_[i].wall_s;
  const double step_s = elapsed_s + step_left_s;
  const double foreseen_s =
      foreseen_s_ + (step_s > 0.0 ? expected_[step_].wall_s * elapsed_s / step_s : 0.0);
  const double slower = (taken_s_ + elapsed_s + trust_s_) / (foreseen_s + trust_s_);
  return step_left_s + later_s * std::clamp(slower, 0.05, 50.0);
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
