#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "passes/trajectory/following/follower.h"

// Part of estimate-trajectory.

namespace sightline {

// Follows a drive from every step that a piece may begin with, until ten scans tell them apart.
// Of the first two scans alone the best match may be the wrong one: rings on the road and along
// walls lie on each other whether the vehicle moved or not, and who begins at speed would stand.
// What stands upright tells: of a wrong motion ever less of it meets what was seen before.
class FirstSteps {
 public:
  explicit FirstSteps(Follower follower) : followed_{std::move(follower)} {}

  // The next scan of the drive.
  void take(const ReadScan& scan);
  // Ends with the likeliest where the drive ends before ten scans have told.
  [[nodiscard]] Odometry take_odometry() &&;
  [[nodiscard]] std::size_t scan_count() const;

 private:
  void begin_trials(const ReadScan& scan);
  void forget_beaten();
  void end_trials();
  void forget_trial();

  // One where the first step is known; else the one first whose first step matches best.
  std::vector<Follower> followed_;
  // While a trial lasts: what was known before it, and what it saw.
  std::vector<Follower> before_;
  std::vector<ReadScan> scans_;
  std::size_t trial_begin_ = 0;  // scan
};

}  // namespace sightline
