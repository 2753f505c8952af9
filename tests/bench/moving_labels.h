#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "formats/base/result.h"
#include "formats/geometry.h"

namespace sightline {

// An object in one scan, as a person labelled it.
struct LabelBox {
  std::string object;  // the same in every scan
  Pose T_lidar_box = Pose::Identity();
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();

  [[nodiscard]] bool contains(const Eigen::Vector3d& point_lidar_m, double margin_m) const {
    const Eigen::Vector3d inside_m = T_lidar_box.inverse(Eigen::Isometry) * point_lidar_m;
    return (inside_m.array().abs() <= half_m.array() + margin_m).all();
  }
};

// The boxes of one scan: a list of {obj_id, psr: {position, rotation, scale}}, metres and radians
// in the sensor's frame, turned about z alone. Errors: cannot-open, bad-value.
Result<std::vector<LabelBox>> read_label_boxes(const std::filesystem::path& file);

enum class LabelMotion : std::uint8_t { kUnknown, kStood, kMoved };

// Of each object seen 4 times or more: it moved when the middle of its places in the last quarter
// of them lies over 2 m from that of the first quarter, else it stood. Single boxes may lie metres
// off. A box that repeats an earlier one of its object to the last digit was copied, not seen: it
// does not count here. One pose for each scan.
std::unordered_map<std::string, LabelMotion> motions_of(
    const std::vector<std::vector<LabelBox>>& boxes, const std::vector<Pose>& T_map_lidar);

}  // namespace sightline
