#include "formats/foreign/clouds/float_columns.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

constexpr std::size_t kLeastColumns = 3;
constexpr std::size_t kMostColumns = 64;

Error bad_columns(const std::string& what) {
  return {ErrorCode::kBadValue,
          "columns: " + what +
              ", expected how many floats a point has (3 to 64) or their names with x, y and z "
              "among them, such as x y z intensity ring"};
}

Result<FloatColumns> named_columns(const std::vector<std::string_view>& names) {
  FloatColumns columns{names.size(), {0, 0, 0}, std::nullopt, std::nullopt};
  std::array<bool, 3> has = {false, false, false};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    const bool is_repeated = std::find(names.begin(), names.begin() + static_cast<long>(i), name) !=
                             names.begin() + static_cast<long>(i);
    const bool is_second = (is_intensity_name(name) && columns.intensity) ||
                           (is_time_name(name) && columns.time) || (is_repeated && name != "_");
    if (is_second) return bad_columns("found a second " + in_quotes(name));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (name != std::string_view("xyz").substr(axis, 1)) continue;
      columns.position[axis] = i;
      has[axis] = true;
    }
    if (is_intensity_name(name)) columns.intensity = i;
    if (is_time_name(name)) columns.time = i;
  }
  if (!has[0] || !has[1] || !has[2]) return bad_columns("found no x, y or z");
  return columns;
}

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

// No LiDAR sees farther than 100 km; a larger number means that these are no coordinates in metres.
bool is_too_far(const Eigen::Vector3d& point_m) {
  constexpr double kFarthest_m = 1e5;
  return (point_m.array().isFinite() && point_m.array().abs() > kFarthest_m).any();
}

}  // namespace

FloatColumns columns_of_count(std::size_t count) {
  FloatColumns columns;
  columns.count = count;
  if (count == kLeastColumns) columns.intensity.reset();
  return columns;
}

Result<FloatColumns> parse_float_columns(std::string_view text) {
  std::vector<std::string_view> words;
  split_words(text, words, " \t\r\n,");
  if (words.size() == 1) {
    const std::optional<std::size_t> count = to_number<std::size_t>(words.front());
    if (!count || *count < kLeastColumns || *count > kMostColumns) {
      return bad_columns("found " + in_quotes(text));
    }
    return columns_of_count(*count);
  }
  if (words.size() > kMostColumns) {
    return bad_columns("found " + std::to_string(words.size()) + " names");
  }
  return named_columns(words);
}

std::string to_text(const FloatColumns& columns) {
  std::string text;
  for (std::size_t i = 0; i < columns.count; ++i) {
    std::string name = "_";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (columns.position[axis] == i) name = std::string_view("xyz").substr(axis, 1);
    }
    if (columns.intensity == i) name = "intensity";
    if (columns.time == i) name = "time";
    text += (text.empty() ? "" : " ") + name;
  }
  return text;
}

// A .bin has no header: float32, little-endian, one point after the other. KITTI writes x y z
// intensity, nuScenes a fifth float, others three, six or eight.

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
  const std::size_t count = file.bytes.size() / point_size;
  const auto value = [&](std::size_t point, std::size_t column) {
    return read_at<float>(file.bytes, point * point_size + column * sizeof(float));
  };
  const auto& [x, y, z] = columns.position;
  PointCloudFile cloud;
  cloud.float_count = columns.count;
  cloud.points_m.reserve(count);
  cloud.intensity.reserve(count);
  std::vector<double> times;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d point_m(value(i, x), value(i, y), value(i, z));
    if (is_too_far(point_m)) {
      return file.error(ErrorCode::kUnsupportedFormat,
                        "found a coordinate beyond 100 km with float32 " + to_text(columns) +
                            "; name the columns with `columns`, or convert it to binary PCD",
                        at_byte(i * point_size));
    }
    const float intensity = columns.intensity ? value(i, *columns.intensity) : 0.0F;
    const bool is_return = add_point(cloud, point_m, intensity);
    if (is_return && columns.time) times.push_back(value(i, *columns.time));
  }
  if (columns.time) set_point_times(times, cloud);
  return cloud;
}

}  // namespace sightline
