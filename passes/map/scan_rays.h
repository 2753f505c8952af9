#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sightline {

// One question to the rays of a scan, in the sensor's frame, metres.
struct RayQuery {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  double touch_m = 0.0;  // a ray that comes this near goes through
  // Where positive a ray counts only if it passes at least this far below, against `up`.
  double least_below_m = 0.0;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  // A ray that ends lower than this, along `up` from the sensor, does not count.
  double lowest_end_m = -std::numeric_limits<double>::infinity();
};

// The rays of one scan, from the sensor's origin to its returns, found by direction. What the
// sensor's beams do not cover, or lost, is covered by no ray and says nothing. Takes one scan after
// another and keeps its memory.
class ScanRays {
 public:
  ScanRays() = default;
  explicit ScanRays(std::span<const Eigen::Vector3d> points_lidar_m) { take(points_lidar_m); }

  // The rays to these returns in place of those before.
  void take(std::span<const Eigen::Vector3d> points_lidar_m);

  // Whether some ray comes within touch_m of a point and ends more than kEndMargin_m beyond it.
  [[nodiscard]] bool pass_through(const RayQuery& query) const;

  // A ray says nothing of the last stretch before its end: range noise, and the slant of what it
  // hit.
  static constexpr double kEndMargin_m = 0.5;

 private:
  struct Ray {
    Eigen::Vector3d direction;
    double range_m;
  };
  // False where no ray's elevation is near enough to that of a point; often true all the same.
  [[nodiscard]] bool may_pass(const RayQuery& query, double distance_m) const;
  [[nodiscard]] bool any_in_bin(std::size_t bin, const RayQuery& query) const;

  std::vector<Ray> rays_;             // by bin, in the scan's order within one
  std::vector<std::uint32_t> begin_;  // of each bin in rays_, and the end of the last
  // At least the longest of the rays of each bin, and of each row of bins.
  std::vector<float> longest_m_;
  std::vector<float> longest_of_row_m_;
  // Of each narrow band of elevation the first from there on that holds a ray, or the number of
  // bands.
  std::vector<std::uint16_t> next_band_;
  std::vector<std::uint32_t> bins_;  // of the returns
};

}  // namespace sightline
