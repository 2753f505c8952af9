#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/trajectory/local/local_match.h"

namespace sightline {

// A longer step ends a piece: 1 s, and three times the median step.
std::int64_t longest_step_ns(const Drive& drive);

// A step of the vehicle's motion and how long it took.
struct TimedStep {
  Pose T_before_after = Pose::Identity();
  std::int64_t time_ns = 0;
};

// The motion extended to another time along its arc; at most ten times as long.
Pose carried_on(const TimedStep& step, std::int64_t time_ns);

// Running means over the latest scans: a scan far below them was matched in a wrong place.
struct RunningAverage {
  double likelihood = 0.0;
  double scored_share = 0.0;
  double overlap = 0.0;

  void add(const LocalMatch& match, std::optional<double> scan_overlap);
  [[nodiscard]] bool is_met_by(const LocalMatch& match) const;
};

// The best match from the starts; where it is worse than usual, from harder turns and other speeds
// too, and where it is not good or the speed is not known yet, from all places within 3 m.
LocalMatch follow(const LocalGrids& grids, const std::vector<Eigen::Vector3d>& points_m,
                  const std::vector<Pose>& starts, const Pose& T_map_before,
                  const RunningAverage& average);

}  // namespace sightline
