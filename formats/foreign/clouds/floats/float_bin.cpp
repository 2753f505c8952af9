#include "formats/foreign/clouds/floats/float_bin.h"

#include <bit>
#include <cstring>

#include "formats/foreign/clouds/points/add_point.h"
#include "formats/foreign/clouds/points/point_times.h"

// A .bin has no header: float32, little-endian, one point after the other. KITTI writes x y z
// intensity, nuScenes a fifth float, others three, six or eight.

namespace sightline {
namespace {

// Those that the caller knows, or how many the floats themselves speak for.
Result<FloatColumns> columns_of(const FileBytes& file, const std::optional<FloatColumns>& columns) {
  if (columns) return *columns;
  const std::size_t size = file.bytes.size();
  const FloatCounts fitting = fitting_counts(file);
  const Result<std::size_t> count = the_one_count(fitting, dividing_counts(size));
  if (count) return columns_of_count(*count);
  const bool is_one = std::has_single_bit(fitting);
  const std::size_t point_size =
      is_one ? static_cast<std::size_t>(std::countr_zero(fitting)) * sizeof(float) : size;
  return file.error(count.error().code, count.error().message,
                    at_byte(size / point_size * point_size));
}

class PointReader {
 public:
  PointReader(const FileBytes& file, const FloatColumns& columns)
      : file_(file), columns_(columns), size_(columns.count * sizeof(float)) {}

  [[nodiscard]] std::size_t count() const { return file_.bytes.size() / size_; }

  [[nodiscard]] float value(std::size_t point, std::size_t column) const {
    float value = 0.0F;
    std::memcpy(&value, file_.bytes.data() + point * size_ + column * sizeof value, sizeof value);
    return value;
  }

  [[nodiscard]] Eigen::Vector3d position_m(std::size_t point) const {
    const auto& [x, y, z] = columns_.position;
    return {value(point, x), value(point, y), value(point, z)};
  }

 private:
  const FileBytes& file_;
  const FloatColumns& columns_;
  std::size_t size_;
};

// No LiDAR sees farther than 100 km; a larger number means that these are no coordinates in metres.
bool is_too_far(const Eigen::Vector3d& point_m) {
  constexpr double kFarthest_m = 1e5;
  return (point_m.array().isFinite() && point_m.array().abs() > kFarthest_m).any();
}

}  // namespace

FloatCounts fitting_counts(const FileBytes& file) {
  constexpr std::size_t kNuscenes = 5;
  const FloatCounts fitting = fitting_counts(file.bytes);
  const bool is_nuscenes = file.file.ends_with(".pcd.bin") && (fitting & only(kNuscenes)) != 0;
  return is_nuscenes ? only(kNuscenes) : fitting;
}

Result<PointCloudFile> parse_float_bin(const FileBytes& file,
                                       const std::optional<FloatColumns>& given) {
  SIGHTLINE_ASSIGN(const FloatColumns columns, columns_of(file, given));
  const std::size_t point_size = columns.count * sizeof(float);
  if (file.bytes.size() % point_size != 0) {
    return file.error(ErrorCode::kTruncatedScan,
                      "found " + std::to_string(file.bytes.size()) +
                          " bytes, expected a multiple of " + std::to_string(point_size) +
                          " (float32 " + to_text(columns) + ")",
                      at_byte(file.bytes.size() / point_size * point_size));
  }
  const PointReader points(file, columns);
  PointCloudFile cloud;
  cloud.float_count = columns.count;
  cloud.points_m.reserve(points.count());
  cloud.intensity.reserve(points.count());
  std::vector<double> times;
  for (std::size_t i = 0; i < points.count(); ++i) {
    const Eigen::Vector3d point_m = points.position_m(i);
    if (is_too_far(point_m)) {
      return file.error(ErrorCode::kUnsupportedFormat,
                        "found a coordinate beyond 100 km with float32 " + to_text(columns) +
                            "; name the columns with `columns`, or convert it to binary PCD",
                        at_byte(i * point_size));
    }
    const float intensity = columns.intensity ? points.value(i, *columns.intensity) : 0.0F;
    const bool is_return = add_point(cloud, point_m, intensity);
    if (is_return && columns.time) times.push_back(points.value(i, *columns.time));
  }
  if (columns.time) set_point_times(times, cloud);
  return cloud;
}

}  // namespace sightline
