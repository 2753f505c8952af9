#include "passes/ingest/check_frame.h"

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

// Of one scan.
struct Placed {
  std::size_t scan = 0;
  Eigen::Vector2d sensor_m;  // by its pose
  Eigen::Vector2d middle_m;  // of its points, as the file has them
};

Eigen::Vector2d middle_of(const PointCloudFile& cloud) {
  Eigen::Vector2d middle_m;
  std::vector<double> values_m(cloud.points_m.size());
  for (const int axis : {0, 1}) {
    for (std::size_t i = 0; i < values_m.size(); ++i) values_m[i] = cloud.points_m[i][axis];
    const auto middle = values_m.begin() + static_cast<std::ptrdiff_t>(values_m.size() / 2);
    std::ranges::nth_element(values_m, middle);
    middle_m[axis] = *middle;
  }
  return middle_m;
}

Result<std::vector<Placed>> placed_scans(const Recording& recording) {
  constexpr std::size_t kScans = 8;
  std::vector<Placed> placed;
  const std::size_t count = recording.scans.size();
  for (std::size_t k = 0; k < std::min(kScans, count); ++k) {
    const std::size_t scan =
        k * (count - 1) / std::max<std::size_t>(1, std::min(kScans, count) - 1);
    const Result<PointCloudFile> cloud = read_listed_scan(recording, scan);
    if (!cloud && is_without_returns(cloud.error())) continue;
    if (!cloud) return cloud.error();
    const std::optional<Pose>& pose = recording.scans[scan].T_world_vehicle;
    if (cloud->points_m.empty() || !(pose || cloud->viewpoint_m)) continue;
    const Eigen::Vector3d sensor_m =
        pose ? Eigen::Vector3d(pose->translation()) : *cloud->viewpoint_m;
    placed.push_back({scan, sensor_m.head<2>(), middle_of(*cloud)});
  }
  return placed;
}

// How far two scans are apart, by poses and by their points.
struct Way {
  Placed from;
  Placed to;
  [[nodiscard]] double apart_m() const { return (to.sensor_m - from.sensor_m).norm(); }
  // 0 where the points moved as the sensor, 1 where they did not move.
  [[nodiscard]] double left_behind() const {
    const Eigen::Vector2d sensor_m = to.sensor_m - from.sensor_m;
    const Eigen::Vector2d points_m = to.middle_m - from.middle_m;
    return (points_m - sensor_m).norm() / sensor_m.norm();
  }
};

std::vector<Way> long_ways(const std::vector<Placed>& placed) {
  constexpr double kLeast_m = 30.0;
  std::vector<Way> ways;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t j = i + 1; j < placed.size(); ++j) {
      const Way way{placed[i], placed[j]};
      if (way.apart_m() >= kLeast_m) ways.push_back(way);
    }
  }
  return ways;
}

Error registered(const Recording& recording, const std::string& evidence) {
  return {ErrorCode::kUnsupportedFormat,
          concat("the scans are in the frame of the poses, expected the frame of the sensor: ",
                 evidence,
                 ". Use the clouds before they are registered (of FAST-LIO: "
                 "/cloud_registered_body)"),
          recording.source.string()};
}

}  // namespace

Result<void> check_frame(const Recording& recording) {
  constexpr double kMovesAlong = 0.4;
  SIGHTLINE_ASSIGN(const std::vector<Placed> placed, placed_scans(recording));
  std::vector<Way> ways = long_ways(placed);
  // Without a way, nothing shows whether the points move with the sensor.
  if (ways.empty()) return {};
  const bool is_one_frame = recording.container && !recording.world_frame.empty() &&
                            recording.container->frame() == recording.world_frame;
  const auto middle = ways.begin() + static_cast<std::ptrdiff_t>(ways.size() / 2);
  std::ranges::nth_element(ways, middle, {}, &Way::left_behind);
  if (middle->left_behind() > kMovesAlong) return {};
  const Way& way = *middle;
  return registered(
      recording,
      concat("between ", recording.scans[way.from.scan].name, " and ",
             recording.scans[way.to.scan].name, " their points move ",
             fixed((way.to.middle_m - way.from.middle_m).norm(), 0), " m and the poses ",
             fixed(way.apart_m(), 0), " m",
             is_one_frame ? ", and both name the frame '" + recording.world_frame + "'" : ""));
}

}  // namespace sightline
