#include "passes/trajectory/following/scan_before.h"

#include <cmath>

namespace sightline {
namespace {

// Scans 13 m apart overlap by 0.4 at the right step, and by up to 0.35 at wrong ones.
constexpr double kSurelyRight = 0.5;
// The search, in steps of about the width within which points meet.
constexpr double kReach_m = 25.0;
constexpr double kStep_m = 0.2;
constexpr double kElsewhere_m = 3.0;
constexpr double kLeastMotion_m = 3.0;

}  // namespace

void ScanBefore::set(const std::vector<Eigen::Vector3d>& upright_m, const Pose& T_map_lidar) {
  at_map_m_ = T_map_lidar.translation();
  upright_ = UprightMap(1.0);
  upright_.add(upright_m, T_map_lidar, 0.0);
}

std::optional<double> ScanBefore::overlap(const std::vector<Eigen::Vector3d>& upright_m,
                                          const Pose& T_map_lidar) const {
  return upright_.overlap(upright_m, T_map_lidar);
}

std::optional<double> ScanBefore::rival_m(const std::vector<Eigen::Vector3d>& upright_m,
                                          const Pose& T_map_lidar, const Eigen::Vector3d& ahead,
                                          double farthest_m) const {
  const std::optional<double> here = overlap(upright_m, T_map_lidar);
  if (!here || *here >= kSurelyRight) return std::nullopt;
  double most = *here + kClearlyMoreOverlap;
  std::optional<double> rival_m;
  const int reach = static_cast<int>(kReach_m / kStep_m);
  for (int i = -reach; i <= reach; ++i) {
    const double off_m = kStep_m * i;
    const Pose T_map_there = Eigen::Translation3d(off_m * ahead) * T_map_lidar;
    const double motion_m = (T_map_there.translation() - at_map_m_).norm();
    const bool is_moved = motion_m >= kLeastMotion_m && motion_m <= farthest_m;
    if (std::abs(off_m) < kElsewhere_m || !is_moved) continue;
    const double there = overlap(upright_m, T_map_there).value_or(0.0);
    if (there <= most) continue;
    most = there;
    rival_m = off_m;
  }
  return rival_m;
}

}  // namespace sightline
