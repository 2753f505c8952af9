#include <cstring>

#include "formats/foreign/clouds/cloud_parsers.h"

// KITTI's .bin has no header: float32 x y z intensity, little-endian, one point after the other.
// nuScenes' .pcd.bin is the same with a fifth float, the ring. All that can be checked is whether
// the numbers could be a scan.

namespace sightline {
namespace {

constexpr std::size_t kKittiSize = 4 * sizeof(float);
constexpr std::size_t kNuscenesSize = 5 * sizeof(float);

// The ring is a small whole number, which no other column of a whole scan is by chance.
bool has_rings(std::span<const std::byte> bytes) {
  constexpr float kMostRings = 128.0F;
  if (bytes.size() % kNuscenesSize != 0) return false;
  for (std::size_t at = 0; at < bytes.size(); at += kNuscenesSize) {
    float ring = 0.0F;
    std::memcpy(&ring, bytes.data() + at + kKittiSize, sizeof ring);
    if (!(ring >= 0.0F && ring < kMostRings && ring == std::floor(ring))) return false;
  }
  return true;
}

// By its name, or by what it holds: both kinds are often renamed to .bin.
bool is_nuscenes(const FileBytes& file) {
  // A KITTI file of a few points may look as if it had rings.
  constexpr std::size_t kLeastSize = 8 * kNuscenesSize;
  if (file.file.ends_with(".pcd.bin")) return true;
  return file.bytes.size() >= kLeastSize && has_rings(file.bytes);
}

}  // namespace

Result<PointCloudFile> parse_float_bin(const FileBytes& file) {
  // No LiDAR sees farther; a larger number means that these are not coordinates in metres.
  constexpr float kFarthest_m = 1e5F;
  const bool nuscenes = is_nuscenes(file);
  const std::size_t point_size = nuscenes ? kNuscenesSize : kKittiSize;
  if (file.bytes.size() % point_size != 0) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found " + std::to_string(file.bytes.size()) +
                          " bytes, expected a multiple " +
                          (nuscenes ? "of 20 (nuScenes: float32 x y z intensity ring)"
                                    : "of 16 (KITTI: float32 x y z intensity)"),
                      at_byte(file.bytes.size() / point_size * point_size));
  }
  PointCloudFile cloud;
  cloud.points_m.reserve(file.bytes.size() / point_size);
  cloud.intensity.reserve(file.bytes.size() / point_size);
  for (std::size_t at = 0; at < file.bytes.size(); at += point_size) {
    float value[4];
    std::memcpy(value, file.bytes.data() + at, sizeof value);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::isfinite(value[axis]) && std::abs(value[axis]) > kFarthest_m) {
        return file.error(ErrorCode::kUnsupportedFormat,
                          "found a coordinate beyond 100 km, expected float32 x y z intensity as "
                          "KITTI and nuScenes write them; convert it to binary PCD",
                          at_byte(at));
      }
    }
    add_point(cloud, Eigen::Vector3d(value[0], value[1], value[2]), value[3]);
  }
  return cloud;
}

}  // namespace sightline
