#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/floats/float_columns.h"
#include "formats/foreign/clouds/floats/float_counts.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/field_names.h"

// What the parsers of formats/foreign share; not for other folders.

namespace sightline {

// A file in memory, and its name for messages.
struct FileBytes {
  std::span<const std::byte> bytes;
  std::string file;
  std::optional<FloatColumns> columns = {};  // of a .bin; nothing: what its floats speak for

  [[nodiscard]] std::string_view text() const {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  [[nodiscard]] Error error(ErrorCode code, std::string message, std::string place) const {
    return {code, std::move(message), file, std::move(place)};
  }
};

inline std::string at_byte(std::size_t offset) { return "byte " + std::to_string(offset); }
inline std::string at_line(std::size_t number) { return "line " + std::to_string(number); }

// Keeps a return and says true; drops and counts what is none.
inline bool add_point(PointCloudFile& cloud, const Eigen::Vector3d& point_m, float intensity) {
  if (!point_m.allFinite()) {
    ++cloud.nonfinite_count;
    return false;
  }
  if (point_m.isZero(0.0)) {
    ++cloud.zero_count;
    return false;
  }
  cloud.points_m.push_back(point_m);
  cloud.intensity.push_back(intensity);
  return true;
}

// Some writers pad a file to whole pages with zeros, and editors add line ends. Anything else
// behind the data means that the header and the data disagree.
inline bool is_padding(std::string_view rest) {
  return rest.find_first_not_of(std::string_view("\0\r\n", 3)) == std::string_view::npos;
}

// Each refuses what contradicts itself; none drops the check for points that were all left out.
Result<PointCloudFile> parse_pcd(const FileBytes& file);
Result<PointCloudFile> parse_ply(const FileBytes& file);
Result<PointCloudFile> parse_las(const FileBytes& file);
// Float32 without a header: KITTI's four floats a point, nuScenes' five, and others.
Result<PointCloudFile> parse_float_bin(const FileBytes& file);

// Those of its floats; of several only nuScenes' five where the name is one of theirs (.pcd.bin).
FloatCounts fitting_counts(const FileBytes& file);

}  // namespace sightline
