#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "passes/trajectory/following/follower.h"

namespace sightline {

// Follows a drive from every step that a piece may begin with, until ten scans distinguish them. Of
// the first two scans alone the best match may be wrong: rings on the road and along walls coincide
// whether the vehicle moved or not, so a vehicle that begins at speed would seem to stand still.
// After a wrong motion, ever less of what is upright meets earlier scans.
class FirstSteps {
 public:
  explicit FirstSteps(Follower follower) : followed_{std::move(follower)} {}

  // The next scan of the drive.
  void take(const ReadScan& scan);
  // Chooses the best so far where the drive ends before ten scans.
  [[nodiscard]] Odometry take_odometry() &&;
  [[nodiscard]] std::size_t scan_count() const;

 private:
  void begin_trials(const ReadScan& scan);
  void forget_beaten();
  void end_trials();
  void forget_trial();

  // One where the first step is known; else several, first the one whose first step matches best.
  std::vector<Follower> followed_;
  // During a trial: the follower before it, and its scans.
  std::vector<Follower> before_;
  std::vector<ReadScan> scans_;
  std::size_t trial_begin_ = 0;  // scan
};

}  // namespace sightline
