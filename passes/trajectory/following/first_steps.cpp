#include "passes/trajectory/following/first_steps.h"

#include <algorithm>
#include <utility>

namespace sightline {
namespace {

// After so many scans a wrong speed is metres off.
constexpr std::size_t kTrialScans = 10;
// A follower with so much less overlap than the best is dropped earlier.
constexpr double kFarBehind = 0.1;
// The drive followed again at the best speed is preferred where it loses no more overlap.
constexpr double kAsGood = 0.005;
// Followers nearer to each other are on one way.
constexpr double kOneWay_m = 0.3;

// Mean over the scans from `begin` on; 0 for a scan that was found nowhere.
double mean_overlap(const Odometry& odometry, std::size_t begin) {
  double sum = 0.0;
  for (std::size_t k = begin; k < odometry.overlap.size(); ++k) {
    sum += odometry.overlap[k].value_or(0.0);
  }
  return sum / static_cast<double>(odometry.overlap.size() - begin);
}

bool are_one(const Follower& a, const Follower& b) {
  const Pose& T_map_a = a.odometry.T_map_lidar.back();
  const Pose& T_map_b = b.odometry.T_map_lidar.back();
  return (T_map_a.translation() - T_map_b.translation()).norm() < kOneWay_m;
}

}  // namespace

void FirstSteps::take(const ReadScan& scan) {
  if (followed_.size() == 1 && followed_.front().is_at_first_step()) {
    begin_trials(scan);
    return;
  }
  const bool is_trial = followed_.size() > 1;
  if (is_trial) scans_.push_back(scan);
  for (Follower& follower : followed_) follower.take(scan);
  if (!is_trial) return;
  forget_beaten();
  if (followed_.size() == 1 || scan_count() == trial_begin_ + kTrialScans) end_trials();
}

void FirstSteps::begin_trials(const ReadScan& scan) {
  trial_begin_ = scan_count();
  scans_ = {scan};
  before_ = followed_;
  const Follower& before = before_.front();
  followed_.front().take(scan);
  const bool is_found = followed_.front().odometry.is_matched.back();
  const std::vector<LocalMatch> steps =
      is_found ? before.first_steps(scan) : std::vector<LocalMatch>();
  for (const LocalMatch& step : steps) {
    Follower other = before;
    other.take_there(scan, step);
    if (!are_one(other, followed_.front())) followed_.push_back(std::move(other));
  }
  if (followed_.size() == 1) forget_trial();
}

// Drops followers that are where a better one is, or far behind the best.
void FirstSteps::forget_beaten() {
  std::vector<double> worths;
  for (const Follower& follower : followed_) {
    worths.push_back(mean_overlap(follower.odometry, trial_begin_));
  }
  const double most = std::ranges::max(worths);
  std::vector<Follower> left;
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    bool is_beaten = worths[i] < most - kFarBehind;
    for (std::size_t j = 0; j < followed_.size(); ++j) {
      const bool is_better = worths[j] > worths[i] || (worths[j] == worths[i] && j < i);
      is_beaten = is_beaten || (is_better && are_one(followed_[i], followed_[j]));
    }
    if (!is_beaten) left.push_back(followed_[i]);
  }
  followed_ = std::move(left);
}

// A follower that reached the right speed may have begun with a step or two that were wrong: the
// drive is followed again from that speed, and preferred where the overlap is as large.
void FirstSteps::end_trials() {
  const auto worth = [&](const Follower& one) { return mean_overlap(one.odometry, trial_begin_); };
  Follower best = *std::ranges::max_element(followed_, {}, worth);
  Follower again = before_.front();
  again.begin_with(scans_.front(), best.last_step());
  for (std::size_t i = 1; i < scans_.size(); ++i) again.take(scans_[i]);
  const bool is_as_good = worth(again) >= worth(best) - kAsGood;
  followed_ = {is_as_good ? std::move(again) : std::move(best)};
  forget_trial();
}

void FirstSteps::forget_trial() {
  before_.clear();
  scans_.clear();
}

Odometry FirstSteps::take_odometry() && {
  if (followed_.size() > 1) end_trials();
  return std::move(followed_.front().odometry);
}

std::size_t FirstSteps::scan_count() const { return followed_.front().odometry.T_map_lidar.size(); }

}  // namespace sightline
