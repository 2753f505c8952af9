#include "tests/bench/moving_labels.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

namespace sightline {
namespace {

constexpr std::size_t kLeastSeen = 4;
constexpr double kMoved_m = 2.0;
constexpr double kJump_m = 4.0;  // from one scan to the next: 40 m/s

Eigen::Vector3d vector_of(const nlohmann::json& json) {
  return {json.at("x").get<double>(), json.at("y").get<double>(), json.at("z").get<double>()};
}

LabelBox box_of(const nlohmann::json& json) {
  const nlohmann::json& psr = json.at("psr");
  const double yaw_rad = vector_of(psr.at("rotation")).z();
  LabelBox box;
  box.object = json.at("obj_id").get<std::string>();
  box.T_lidar_box.translation() = vector_of(psr.at("position"));
  box.T_lidar_box.linear() =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  box.half_m = 0.5 * vector_of(psr.at("scale"));
  return box;
}

struct Track {
  std::vector<Eigen::Vector3d> at_lidar_m;  // of its scans
  std::vector<Eigen::Vector3d> at_map_m;    // without jumps
  Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
  std::size_t last_scan = 0;
  Eigen::Vector3d jumped_m = Eigen::Vector3d::Zero();
};

// Coordinate by coordinate.
Eigen::Vector3d median_m(std::span<const Eigen::Vector3d> places_m) {
  Eigen::Vector3d middle_m;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values_m;
    for (const Eigen::Vector3d& at_m : places_m) values_m.push_back(at_m[axis]);
    std::ranges::sort(values_m);
    middle_m[axis] = values_m[values_m.size() / 2];
  }
  return middle_m;
}

LabelMotion motion_of(std::span<const Eigen::Vector3d> places_m) {
  if (places_m.size() < kLeastSeen) return LabelMotion::kUnknown;
  const std::size_t quarter = places_m.size() / 4;
  const Eigen::Vector3d way_m =
      median_m(places_m.last(quarter)) - median_m(places_m.first(quarter));
  return way_m.norm() > kMoved_m ? LabelMotion::kMoved : LabelMotion::kStood;
}

}  // namespace

Result<std::vector<LabelBox>> read_label_boxes(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return Error{ErrorCode::kCannotOpen, "cannot be opened", file.string()};
  try {
    std::vector<LabelBox> boxes;
    for (const nlohmann::json& json : nlohmann::json::parse(in)) boxes.push_back(box_of(json));
    return boxes;
  } catch (const nlohmann::json::exception& problem) {
    return Error{ErrorCode::kBadValue, problem.what(), file.string()};
  }
}

std::unordered_map<std::string, LabelMotion> motions_of(
    const std::vector<std::vector<LabelBox>>& boxes, const std::vector<Pose>& T_map_lidar) {
  std::unordered_map<std::string, Track> tracks;
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    for (const LabelBox& box : boxes[k]) {
      Track& track = tracks[box.object];
      const Eigen::Vector3d at_lidar_m = box.T_lidar_box.translation();
      if (std::ranges::find(track.at_lidar_m, at_lidar_m) != track.at_lidar_m.end()) continue;
      const Eigen::Vector3d at_m = T_map_lidar[k] * at_lidar_m;
      if (!track.at_lidar_m.empty()) {
        const Eigen::Vector3d step_m = at_m - track.last_m;
        const double most_m =
            kJump_m * static_cast<double>(std::max<std::size_t>(k - track.last_scan, 1));
        if (step_m.norm() > most_m) track.jumped_m += step_m;
      }
      track.last_m = at_m;
      track.last_scan = k;
      track.at_lidar_m.push_back(at_lidar_m);
      track.at_map_m.push_back(at_m - track.jumped_m);
    }
  }
  std::unordered_map<std::string, LabelMotion> motions;
  for (const auto& [object, track] : tracks) motions[object] = motion_of(track.at_map_m);
  return motions;
}

}  // namespace sightline
