#pragma once

#include <cstdint>
#include <deque>

#include "formats/geometry.h"

namespace sightline {

// A step of the vehicle's motion and how long it took.
struct TimedStep {
  Pose T_before_after = Pose::Identity();
  std::int64_t time_ns = 0;
};

// The motion extended to another time along its arc; at most ten times as long.
Pose carried_on(const TimedStep& step, std::int64_t time_ns);

// The mean of the latest steps that scans constrain: constant velocity, for steps that they do not.
// One step alone is off by a percent, which is metres at the end of a tunnel.
class SteadyMotion {
 public:
  void add(const TimedStep& step);
  // Whether enough steps are known: five.
  [[nodiscard]] bool is_known() const;
  // The mean step, extended to another time. Only where it is known.
  [[nodiscard]] Pose step(std::int64_t time_ns) const;

 private:
  std::deque<TimedStep> steps_;
};

}  // namespace sightline
