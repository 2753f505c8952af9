#include "passes/trajectory/given/compare_motion.h"

#include "formats/geometry.h"
#include "passes/trajectory/local/scan_overlap.h"

namespace sightline {
namespace {

// Overlap of upright returns; scans of one street have 0.65 and more.
constexpr double kLeastOverlap = 0.35;
// A contradicted motion has less than this share of the matched one's overlap.
constexpr double kContradictedShare = 0.9;

}  // namespace

double MotionPair::off_m() const { return (given.translation() - matched.translation()).norm(); }

double MotionPair::off_rad() const {
  return rotation_angle_rad(matched.linear().transpose() * given.linear());
}

MotionPair motion_between(const GivenPoses& given, const Odometry& odometry, std::uint32_t from,
                          std::uint32_t to) {
  return {from, to, given[from]->inverse() * *given[to],
          odometry.T_map_lidar[from].inverse() * odometry.T_map_lidar[to]};
}

bool is_matched_through(const Odometry& odometry, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t k = from + 1; k <= to; ++k) {
    if (!odometry.is_matched[k]) return false;
  }
  return true;
}

Result<bool> is_contradicted(const Drive& drive, const MotionPair& motion) {
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  SIGHTLINE_ASSIGN(const ThinnedScan from, read_thinned(drive, motion.from, ThinnedFor::kMap));
  SIGHTLINE_ASSIGN(const ThinnedScan to, read_thinned(drive, motion.to, ThinnedFor::kMatch));
  UprightMap seen(1.0);
  seen.add(upright_points(from.to_map_m, level), Pose::Identity(), 0.0);
  const std::vector<Eigen::Vector3d> upright_m = upright_points(to.to_match_m, level);
  const std::optional<double> matched = seen.overlap(upright_m, motion.matched);
  if (!matched || *matched < kLeastOverlap) return false;
  return seen.overlap(upright_m, motion.given).value_or(0.0) < kContradictedShare * *matched;
}

}  // namespace sightline
