#include <cstring>

#include "formats/foreign/cloud_parsers.h"

// KITTI's .bin has no header: float32 x y z intensity, little-endian, one point after the other.
// All that can be checked is whether the numbers could be a scan.

namespace sightline {
namespace {

constexpr std::size_t kPointSize = 4 * sizeof(float);

// nuScenes writes five floats a point into files of the same name; the fifth is the ring, a small
// whole number. Read as four they would be noise.
bool looks_like_nuscenes(std::span<const std::byte> bytes) {
  constexpr std::size_t kNuscenesSize = 5 * sizeof(float);
  constexpr float kMostRings = 128.0F;
  if (bytes.size() % kNuscenesSize != 0) return false;
  for (std::size_t at = 0; at < bytes.size(); at += kNuscenesSize) {
    float ring = 0.0F;
    std::memcpy(&ring, bytes.data() + at + kPointSize, sizeof ring);
    if (!(ring >= 0.0F && ring < kMostRings && ring == std::floor(ring))) return false;
  }
  // A KITTI file of a few points may look like this by chance.
  return bytes.size() >= 8 * kNuscenesSize;
}

}  // namespace

Result<PointCloudFile> parse_kitti_bin(const FileBytes& file) {
  // No LiDAR sees farther; a larger number means that these are not coordinates in metres.
  constexpr float kFarthest_m = 1e5F;
  if (looks_like_nuscenes(file.bytes)) {
    return file.error(ErrorCode::kUnsupportedFormat,
                      "five floats a point as nuScenes writes them, expected four (x y z "
                      "intensity); drop the fifth column",
                      at_byte(0));
  }
  if (file.bytes.size() % kPointSize != 0) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found " + std::to_string(file.bytes.size()) +
                          " bytes, expected a multiple of 16 (float32 x y z intensity)",
                      at_byte(file.bytes.size() / kPointSize * kPointSize));
  }
  PointCloudFile cloud;
  cloud.points_m.reserve(file.bytes.size() / kPointSize);
  cloud.intensity.reserve(file.bytes.size() / kPointSize);
  for (std::size_t at = 0; at < file.bytes.size(); at += kPointSize) {
    float value[4];
    std::memcpy(value, file.bytes.data() + at, kPointSize);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::isfinite(value[axis]) && std::abs(value[axis]) > kFarthest_m) {
        return file.error(ErrorCode::kUnsupportedFormat,
                          "found a coordinate beyond 100 km, expected float32 x y z intensity as "
                          "KITTI writes them",
                          at_byte(at));
      }
    }
    add_point(cloud, Eigen::Vector3d(value[0], value[1], value[2]), value[3]);
  }
  return cloud;
}

}  // namespace sightline
