#include "passes/trajectory/given/lever_arm.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "formats/symmetric_eigen.h"
#include "passes/trajectory/given/disagreements.h"

namespace sightline {
namespace {

constexpr double kWindow_m = 10.0;
constexpr std::size_t kLeastWindows = 20;
constexpr double kLeastArm_m = 0.2;
constexpr double kExplained = 0.5;  // of the squared differences
// A direction is known where its standard deviation is below this; successive windows overlap, so
// the one by their differences is too small, and is taken ten times.
constexpr double kKnown_m = 0.2;
constexpr double kDependent = 10.0;

// (R - I) a = difference, one for each window.
struct ArmEquation {
  Eigen::Matrix3d by_arm;
  Eigen::Vector3d difference_m;
};

std::vector<ArmEquation> arm_equations(const GivenPoses& given, const Odometry& odometry) {
  std::vector<ArmEquation> equations;
  std::uint32_t last = 0;
  for (std::uint32_t first = 0; first < given.size(); ++first) {
    const auto way_m = [&] { return odometry.driven_m[last] - odometry.driven_m[first]; };
    while (last + 1 < given.size() && way_m() < kWindow_m) ++last;
    if (way_m() < kWindow_m) break;
    if (!given[first] || !given[last] || !is_constrained_through(odometry, first, last)) continue;
    const MotionPair motion = motion_between(given, odometry, first, last);
    equations.push_back({motion.given.linear() - Eigen::Matrix3d::Identity(),
                         motion.matched.translation() - motion.given.translation()});
  }
  return equations;
}

double sum_of_squares_m2(const std::vector<ArmEquation>& equations, const Eigen::Vector3d& arm_m) {
  double sum_m2 = 0.0;
  for (const ArmEquation& one : equations) {
    sum_m2 += (one.difference_m - one.by_arm * arm_m).squaredNorm();
  }
  return sum_m2;
}

// By least squares; along directions that little is known of, 0.
Eigen::Vector3d solved_arm_m(const std::vector<ArmEquation>& equations) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const ArmEquation& one : equations) {
    normal += one.by_arm.transpose() * one.by_arm;
    right += one.by_arm.transpose() * one.difference_m;
  }
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(normal);
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();
  // The best known direction first: what it explains is no error of the next.
  for (int i = 2; i >= 0; --i) {
    if (eigen.values[i] <= 0.0) continue;
    const Eigen::Vector3d along = eigen.vectors.col(i);
    const Eigen::Vector3d more_m = (along.dot(right) / eigen.values[i]) * along;
    const double variance_m2 = sum_of_squares_m2(equations, arm_m + more_m) /
                               (3.0 * static_cast<double>(equations.size()));
    const double sigma_m = kDependent * std::sqrt(variance_m2 / eigen.values[i]);
    if (sigma_m < kKnown_m) arm_m += more_m;
  }
  return arm_m;
}

}  // namespace

std::optional<Eigen::Vector3d> lever_arm_m(const Drive& drive, const GivenPoses& given,
                                           const Odometry& odometry) {
  const std::vector<ArmEquation> equations = arm_equations(given, odometry);
  if (equations.size() < kLeastWindows) return std::nullopt;
  const Eigen::Vector3d arm_m = solved_arm_m(equations);
  const double without_m2 = sum_of_squares_m2(equations, Eigen::Vector3d::Zero());
  const bool explains = sum_of_squares_m2(equations, arm_m) < kExplained * without_m2;
  if (arm_m.norm() < kLeastArm_m || !explains) return std::nullopt;
  const Eigen::Vector3d in_vehicle_m = drive.sensor.T_vehicle_lidar.linear() * arm_m;
  return in_vehicle_m;
}

}  // namespace sightline
