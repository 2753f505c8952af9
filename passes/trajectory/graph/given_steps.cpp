#include "passes/trajectory/graph/given_steps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "passes/trajectory/given/disagreements.h"
#include "passes/trajectory/local/scan_constraint.h"

namespace sightline {
namespace {

constexpr double kWindow_m = 10.0;
constexpr std::size_t kLeastWindows = 5;
// Half of all vectors of three independent numbers are longer than so many standard deviations.
constexpr double kMedianLength = 1.538;

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

Matrix6d in_both(const Eigen::Matrix3d& rotation) {
  Matrix6d both = Matrix6d::Zero();
  both.topLeftCorner<3, 3>() = rotation;
  both.bottomRightCorner<3, 3>() = rotation;
  return both;
}

}  // namespace

GivenDrift given_drift(const EstimateTrajectoryOptions& options, const GivenPoses& given,
                       const Odometry& odometry) {
  // Of two poses with an exponential correlation.
  const double per_root_m = std::sqrt(2.0 / std::max(options.prior_correlation_m, 1.0));
  GivenDrift drift{per_root_m * options.prior_sigma_m,
                   per_root_m * options.prior_sigma_deg * std::numbers::pi / 180.0};
  std::vector<double> off_m;
  std::vector<double> off_rad;
  std::uint32_t last = 0;
  for (std::uint32_t first = 0; first < given.size(); ++first) {
    const auto way_m = [&] { return odometry.driven_m[last] - odometry.driven_m[first]; };
    while (last + 1 < given.size() && way_m() < kWindow_m) ++last;
    if (way_m() < kWindow_m) break;
    if (!given[first] || !given[last]) continue;
    if (!is_constrained_through(odometry, first, last)) continue;
    const MotionPair motion = motion_between(given, odometry, first, last);
    off_m.push_back(motion.off_m() / std::sqrt(way_m()));
    off_rad.push_back(motion.off_rad() / std::sqrt(way_m()));
  }
  if (off_m.size() < kLeastWindows) return drift;
  drift.sigma_m = std::min(drift.sigma_m, median(off_m) / kMedianLength);
  drift.sigma_rad = std::min(drift.sigma_rad, median(off_rad) / kMedianLength);
  return drift;
}

Matrix6d given_motions(const Drive& drive, const Odometry& odometry, std::size_t k) {
  const StepConstraint& step = odometry.constraint[k];
  Matrix6d motions = Matrix6d::Zero();
  if (step.forecast != Forecast::kGiven) return motions;
  Eigen::Matrix<double, 6, 3> of_plane = Eigen::Matrix<double, 6, 3>::Zero();
  of_plane(0, 0) = of_plane(1, 1) = of_plane(5, 2) = 1.0;
  const Matrix6d to_sensor = in_both(drive.sensor.T_vehicle_lidar.linear().transpose());
  const Eigen::Matrix<double, 6, 3> of_sensor = to_sensor * of_plane;
  motions = of_sensor * step.forecast_motions * of_sensor.transpose();
  return motions;
}

void add_given_drift(const Drive& drive, const Odometry& odometry, const GivenDrift& drift,
                     const std::vector<std::uint32_t>& scans, std::vector<GraphEdge>& steps) {
  Vector6d variances;
  variances.head<3>().setConstant(drift.sigma_m * drift.sigma_m);
  // Turns are scaled as in PlanarMotion, and back below.
  variances.tail<3>().setConstant(drift.sigma_rad * drift.sigma_rad * kTurnArm_m * kTurnArm_m);
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 1.0 / kTurnArm_m, 1.0 / kTurnArm_m, 1.0 / kTurnArm_m;
  for (GraphEdge& step : steps) {
    const std::uint32_t from = scans[step.from];
    for (std::uint32_t k = from + 1; k <= scans[step.to]; ++k) {
      const Matrix6d motions = given_motions(drive, odometry, k);
      if (motions.isZero(0.0)) continue;
      const double way_m = odometry.driven_m[k] - odometry.driven_m[k - 1];
      const Matrix6d turned = in_both(odometry.T_map_lidar[from].linear().transpose() *
                                      odometry.T_map_lidar[k].linear());
      const Matrix6d onto = scale.asDiagonal() * turned * motions;
      step.more += way_m * onto * variances.asDiagonal() * onto.transpose();
    }
  }
}

}  // namespace sightline
