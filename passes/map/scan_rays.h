#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/geometry.h"

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

// Places of one neighbourhood that many scans are asked about, as floats: relative to one of them,
// or to something near.
struct RayPlaces {
  Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();
  float radius_m = 0.0F;                 // no place is farther from the anchor
  std::span<const float> x_m, y_m, z_m;  // from there
};

// The direction of a place, as far as it takes to look for rays near it.
struct RaySector {
  float low_sine = 0.0F;  // of the elevation
  float high_sine = 0.0F;
  float turn = 0.0F;                                    // of the azimuth
  float side = std::numeric_limits<float>::infinity();  // to both sides of the turn
  float least_range_m = 0.0F;                           // no ray that passes is shorter
};

// The rays of one scan, from the sensor's origin to its returns, found by direction. Takes one scan
// after another and keeps its memory.
class ScanRays {
 public:
  ScanRays() = default;
  explicit ScanRays(std::span<const Eigen::Vector3d> points_lidar_m) { take(points_lidar_m); }

  // The rays to these returns in place of those before.
  void take(std::span<const Eigen::Vector3d> points_lidar_m);

  // Whether some ray comes within touch_m of a point and ends more than kEndMargin_m beyond it.
  [[nodiscard]] bool pass_through(const RayQuery& query) const;

  // Fills `found` with the positions, ascending, of the places through which a ray may pass; of all
  // others pass_through() is false for any query. `T_lidar_places` takes the places' coordinates,
  // anchor added, to the sensor's frame.
  void find_passable(const RayPlaces& places, const Pose& T_lidar_places, double touch_m,
                     std::vector<std::uint32_t>& found) const;

  // Unused at the end of a ray: range noise, and the slant of what it hit.
  static constexpr double kEndMargin_m = 0.5;

 private:
  struct Ray {
    Eigen::Vector3d direction;
    double range_m;
  };
  void find_bins(std::span<const Eigen::Vector3d> points_lidar_m);
  void find_longest_around();
  // False where no ray's elevation is near enough to that of a point; often true all the same.
  [[nodiscard]] bool may_pass(const RayQuery& query, double distance_m) const;
  [[nodiscard]] bool may_hold_longer(const RaySector& sector) const;
  [[nodiscard]] bool any_in_bin(std::size_t bin, const RayQuery& query) const;

  // Rows of bins that hold no ray have none, and no place among the others.
  std::vector<std::int16_t> place_of_row_;
  std::vector<Ray> rays_;             // by bin, in the scan's order within one
  std::vector<std::uint32_t> begin_;  // of each bin in rays_, and the end of the last
  // At least the longest of the rays of each bin, and of each row of bins.
  std::vector<float> longest_m_;
  std::vector<float> longest_of_row_m_;
  // The same of each bin and those up to 1, 3 and 7 columns to both sides.
  std::array<std::vector<float>, 3> longest_around_m_;
  // Of each narrow band of elevation the first from there on that holds a ray, or the number of
  // bands.
  std::vector<std::uint16_t> next_band_;
  // Of the returns.
  std::vector<std::uint32_t> bins_;
  std::vector<double> ranges_m_;
};

}  // namespace sightline
