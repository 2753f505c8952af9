#include "passes/ingest/check_upright.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/text/numbers.h"
#include "passes/ingest/guess_sensor.h"

namespace sightline {
namespace {

// Shares of near returns by their height over the sensor, in steps of 0.2 m.
class Heights {
 public:
  Heights(const PointCloudFile& cloud, const Eigen::Matrix3d& level) {
    constexpr double kNearest_m = 3.0;
    constexpr double kFarthest_m = 20.0;
    for (const Eigen::Vector3d& point_m : cloud.points_m) {
      const Eigen::Vector3d at_m = level * point_m;
      const double away_m = at_m.head<2>().norm();
      if (!(away_m >= kNearest_m && away_m <= kFarthest_m)) continue;
      const double step = std::floor(at_m.z() / kStep_m) + kZero;
      const double last = static_cast<double>(shares_.size() - 1);
      shares_[static_cast<std::size_t>(std::clamp(step, 0.0, last))] += 1.0;
      count_ += 1.0;
    }
    for (double& share : shares_) share /= std::max(1.0, count_);
  }

  // Height of the ground where it is above the sensor.
  [[nodiscard]] std::optional<double> ground_above_m() const {
    constexpr double kFewest = 200.0;
    constexpr double kLeastGround = 0.15;
    constexpr double kFarMore = 3.0;
    constexpr double kUnderGround = 0.02;
    constexpr std::size_t kFirst = 2;  // steps: 0.4 m
    constexpr std::size_t kLast = 20;
    if (count_ < kFewest) return std::nullopt;
    std::size_t ground = kFirst;
    double most_below = 0.0;
    for (std::size_t step = kFirst; step <= kLast; ++step) {
      if (band(kZero + step) > band(kZero + ground)) ground = step;
      most_below = std::max(most_below, band(kZero - step - 2));
    }
    double higher = 0.0;
    for (std::size_t step = kZero + ground + 4; step < shares_.size(); ++step) {
      higher += shares_[step];
    }
    const double share = band(kZero + ground);
    if (share < kLeastGround || share < kFarMore * most_below || higher > kUnderGround) {
      return std::nullopt;
    }
    const bool is_lower = shares_[kZero + ground] > shares_[kZero + ground + 1];
    return kStep_m * (static_cast<double>(ground) + (is_lower ? 0.5 : 1.5));
  }

 private:
  static constexpr double kStep_m = 0.2;
  static constexpr std::size_t kZero = 50;

  // Two steps, the thickness of a ground that is not quite level.
  [[nodiscard]] double band(std::size_t step) const { return shares_[step] + shares_[step + 1]; }

  std::array<double, 2 * kZero> shares_{};
  double count_ = 0.0;
};

Eigen::Matrix3d level_of(const Drive& drive, std::size_t scan) {
  const Eigen::Matrix3d mounted = drive.sensor.T_vehicle_lidar.linear();
  const std::optional<Pose>& pose = drive.scans[scan].T_world_vehicle;
  return pose ? Eigen::Matrix3d(pose->linear() * mounted) : mounted;
}

}  // namespace

Result<void> check_upright(const Recording& recording, const Drive& drive) {
  std::size_t judged = 0;
  std::vector<double> above_m;
  for (const std::size_t scan : sample_scans(drive.scans.size())) {
    const Result<PointCloudFile> cloud = read_listed_scan(recording, scan);
    if (!cloud && is_without_returns(cloud.error())) continue;
    if (!cloud) return cloud.error();
    ++judged;
    const std::optional<double> ground_m = Heights(*cloud, level_of(drive, scan)).ground_above_m();
    if (ground_m) above_m.push_back(*ground_m);
  }
  if (judged == 0 || 4 * above_m.size() < 3 * judged) return {};
  std::ranges::sort(above_m);
  return Error{ErrorCode::kUnsupportedFormat,
               concat("the ground is ", fixed(above_m[above_m.size() / 2], 1),
                      " m above the sensor in ", above_m.size(), " of ", judged,
                      " scans: the sensor is mounted upside down, or z is negated. Set "
                      "lidar_roll_deg: 180 if the sensor is turned about its x axis; else correct "
                      "the scans"),
               recording.source.string(), "drive " + recording.name};
}

}  // namespace sightline
