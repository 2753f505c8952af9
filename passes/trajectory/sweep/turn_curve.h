#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"

namespace sightline {

// The rotations of a vehicle at two times, by its poses.
struct TurnEnds {
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;  // later
  Eigen::Matrix3d R_map_from = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_map_to = Eigen::Matrix3d::Identity();
};

// How a vehicle turned between two poses, by the turn rates measured between them ("Turning within
// a scan" in schemas/definitions.md, v1): with Q(t) the integral of the rates from the first time
// on, Q' = Q [w]x, and phi a the rotation vector of Q(to)^T R_map_from^T R_map_to,
//   R_map_vehicle(t) = R_map_from Q(t) exp(s phi [a]x),   s = (t - from) / (to - from).
// So both ends are those of the poses, and a constant error of the rates is removed.
class TurnCurve {
 public:
  // Rates ascending in time. None where they do not cover the time from the first to the second
  // end, no two more than 50 ms apart.
  static std::optional<TurnCurve> between(std::span<const TurnRate> rates, const TurnEnds& ends);

  // By the rates alone, without poses: R_map_vehicle is the identity at the first time. None where
  // the rates do not cover the time.
  static std::optional<TurnCurve> by_rates(std::span<const TurnRate> rates, std::int64_t from_ns,
                                           std::int64_t to_ns);

  // R_map_vehicle at a time from the first to the second end; at the ends that of the pose itself.
  [[nodiscard]] Eigen::Matrix3d at(std::int64_t time_ns) const;
  // The largest angle to even turning about one axis, rad.
  [[nodiscard]] double bend_rad() const;

 private:
  // The nodes alone.
  static std::optional<TurnCurve> integrated(std::span<const TurnRate> rates, std::int64_t from_ns,
                                             std::int64_t to_ns);

  struct Node {
    std::int64_t time_ns = 0;
    Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
    Eigen::Matrix3d R_from_node = Eigen::Matrix3d::Identity();  // Q
  };
  TurnEnds ends_;
  std::vector<Node> nodes_;  // both ends and the rates between them
  AxisAngle left_over_;      // phi a
};

// The rates that a curve between two times is made of: those between them, one before and one
// after.
std::span<const TurnRate> rates_around(std::span<const TurnRate> rates, std::int64_t from_ns,
                                       std::int64_t to_ns);

}  // namespace sightline
