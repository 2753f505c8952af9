#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "formats/geometry.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// Where PCL's NDT ended.
struct PclMatch {
  Pose T_map_scan = Pose::Identity();  // the start where there is nothing to match
  int iterations = 0;
};

// PCL's pcl::NormalDistributionsTransform with the numbers of Autoware's ndt_scan_matcher: cells as
// long as the map's (2 m), steps of at most 0.1 m, 30 iterations. Autoware's epsilon is 0.01, a
// length; PCL compares the square of a step with its own, so here it is (0.01 m)^2: with 0.01 no
// step would ever be longer, and every match would end after its first.
//
// PCL makes its target from points, and the map holds their NDs. Both cut space at multiples of the
// cell from the map's origin and take covariances by n - 1, so an ND is PCL's own leaf: count,
// mean, covariance (eigenvalues below 0.01 of the largest raised to that), inverse. They are put in
// as such, and the search tree is PCL's over their means. What differs: PCL also keeps cells of 6
// to 9 points, which the map does not have.
//
// Equal inputs give equal results on one machine. PCL calls its platform's exp, so other machines
// may give other bits. Not safe to share between threads.
class PclNdt {
 public:
  // The NDs within kReach_m of a place, which is what Autoware loads around the vehicle.
  static constexpr double kReach_m = 150.0;
  static constexpr double kStep_m = 0.1;
  static constexpr double kEpsilon_m = 0.01;
  static constexpr int kIterations = 30;
  PclNdt(const NdtMap& map, const Eigen::Vector3d& place_map_m);
  // PCL's own target, to compare with: cells of `cell_m` with at least `fewest` points each.
  PclNdt(std::span<const Eigen::Vector3d> map_points_m, double cell_m, int fewest);
  ~PclNdt();
  PclNdt(PclNdt&&) noexcept;
  PclNdt& operator=(PclNdt&&) noexcept;

  void set_scan(std::span<const Eigen::Vector3d> points_m);
  [[nodiscard]] PclMatch match(const Pose& T_map_start);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Whether this program was built with PCL. Nothing else here may be called without.
bool has_pcl_ndt();

}  // namespace sightline
