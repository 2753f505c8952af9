#include "formats/foreign/clouds/float_columns.h"

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

// Floats that are looked at: all, or of a large file blocks spread over it.
constexpr std::size_t kBlock = 4096;
constexpr std::size_t kBlocks = 8;

constexpr std::size_t kKinds = 1024;

// How often a column holds each kind of number.
using KindHistogram = std::vector<double>;

float float_at(std::span<const std::byte> bytes, std::size_t index) {
  return read_at<float>(bytes, index * sizeof(float));
}

// Power of two in the upper bits, then the sign, then whether it is whole. Each NaN is like
// another.
std::size_t kind_of(float value) {
  constexpr std::size_t kNoNumber = 255U << 2U;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  if (!std::isfinite(value)) return kNoNumber;
  const bool is_whole = value == std::floor(value);
  return ((bits >> 23U & 0xffU) << 2U) | (bits >> 31U << 1U) | (is_whole ? 1U : 0U);
}

// Zeros stand for no return, NaN too: they say nothing of what a column holds.
bool says_something(std::size_t kind) { return kind >> 2U != 0 && kind >> 2U != 255; }

double sum_of(const KindHistogram& counts) {
  double sum = 0.0;
  for (const double count : counts) sum += count;
  return sum;
}

// In bits, with the correction of Miller and Madow for the few samples that there are.
double entropy(const KindHistogram& counts) {
  const double sum = sum_of(counts);
  if (sum == 0.0) return 0.0;
  double bits = 0.0;
  double seen = 0.0;
  for (const double count : counts) {
    if (count == 0.0) continue;
    bits -= count / sum * portable_log2(count / sum);
    seen += 1.0;
  }
  return bits + (seen - 1.0) / (2.0 * sum * std::numbers::ln2);
}

// The floats of a file read with each count of floats a point from 1 to 10. Of a large file only
// blocks spread over it are looked at.
class FloatReadings {
 public:
  explicit FloatReadings(std::span<const std::byte> bytes) : bytes_(bytes) {
    for_each_float([&](std::size_t i) { kinds_.emplace_back(i, kind_of(float_at(bytes_, i))); });
    for (std::size_t count = 1; count <= kMostFloats; ++count) add_reading(count);
  }

  // Whether a count that is no multiple explains the kinds of numbers better.
  [[nodiscard]] bool is_beaten(std::size_t count) const {
    constexpr double kClear_bits = 0.1;
    const double own_bits = readings_[count - 1].entropy_bits;
    for (std::size_t other = kLeastFloats; other <= kMostFloats; ++other) {
      if (other % count == 0) continue;
      if (readings_[other - 1].entropy_bits < own_bits - kClear_bits) return true;
    }
    return false;
  }

  // Whether the columns do not differ, or only every other one: then these are no points.
  [[nodiscard]] bool is_no_point(std::size_t count) const {
    constexpr double kClear_bits = 0.1;  // in recordings they differ by 0.4 and more
    const double own_bits = readings_[count - 1].entropy_bits;
    return std::min(readings_[0].entropy_bits, readings_[1].entropy_bits) < own_bits + kClear_bits;
  }

  // How unlike the points of `count` are that `multiple` makes one, 0 to 1, by what would be x and
  // y.
  [[nodiscard]] double divergence(std::size_t count, std::size_t multiple) const {
    double sum = 0.0;
    double columns = 0.0;
    for (std::size_t column = 0; column < 2; ++column) {
      const std::optional<double> found = divergence_of(column, count, multiple);
      if (!found) continue;
      sum += *found;
      columns += 1.0;
    }
    return columns == 0.0 ? 0.0 : sum / columns;
  }

  // Whether most of them lie within 5 degrees of the one before them.
  [[nodiscard]] bool follow_each_other(std::size_t count, std::size_t multiple) const {
    constexpr double kCosine = 0.996;
    constexpr std::size_t kFewest = 16;
    std::size_t pairs = 0;
    std::size_t near = 0;
    for_each_float([&](std::size_t i) {
      const bool has_next = i % count == 0 && i % multiple + count < multiple;
      if (!has_next || i + count + 1 >= size()) return;
      const Eigen::Vector2d first(float_at(bytes_, i), float_at(bytes_, i + 1));
      const Eigen::Vector2d second(float_at(bytes_, i + count), float_at(bytes_, i + count + 1));
      const double lengths = first.norm() * second.norm();
      if (!(lengths > 0.0) || !std::isfinite(lengths)) return;
      ++pairs;
      near += first.dot(second) > kCosine * lengths ? 1 : 0;
    });
    return pairs >= kFewest && 2 * near > pairs;
  }

  // Whether x, y and z can be coordinates: a ring, a label or a time that stands first cannot, nor
  // can a row of which two are exactly 0 and one is not.
  [[nodiscard]] bool begins_with_coordinates(std::size_t count) const {
    return has_fractions(count, 0) && has_fractions(count, 1) && !is_rising(count) &&
           !has_lone_numbers(count);
  }

 private:
  struct Reading {
    std::vector<KindHistogram> columns;
    double entropy_bits = 0.0;  // of a float, given its column
  };

  [[nodiscard]] std::size_t size() const { return bytes_.size() / sizeof(float); }

  // Calls body(index of a float) for those that are looked at.
  template <class Body>
  void for_each_float(Body body) const {
    const bool takes_all = size() <= kBlock * kBlocks;
    const std::size_t blocks = takes_all ? 1 : kBlocks;
    const std::size_t block = takes_all ? size() : kBlock;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t begin = blocks == 1 ? 0 : (size() - block) / (blocks - 1) * b;
      for (std::size_t i = begin; i < begin + block; ++i) body(i);
    }
  }

  void add_reading(std::size_t count) {
    Reading reading;
    reading.columns.assign(count, KindHistogram(kKinds, 0.0));
    for (const auto& [index, kind] : kinds_) reading.columns[index % count][kind] += 1.0;
    const auto floats = static_cast<double>(kinds_.size());
    for (const KindHistogram& column : reading.columns) {
      reading.entropy_bits += sum_of(column) / floats * entropy(column);
    }
    readings_.push_back(std::move(reading));
  }

  // Nothing where a turn has no numbers in this column.
  [[nodiscard]] std::optional<double> divergence_of(std::size_t column, std::size_t count,
                                                    std::size_t multiple) const {
    constexpr double kFewest = 16.0;
    KindHistogram all(kKinds, 0.0);
    double each_bits = 0.0;
    for (std::size_t at = column; at < multiple; at += count) {
      KindHistogram turn = readings_[multiple - 1].columns[at];
      for (std::size_t kind = 0; kind < kKinds; ++kind) {
        if (!says_something(kind)) turn[kind] = 0.0;
        all[kind] += turn[kind];
      }
      if (sum_of(turn) < kFewest) return std::nullopt;
      each_bits += sum_of(turn) * entropy(turn);
    }
    const double turns = static_cast<double>(multiple / count);
    return std::max(0.0, (entropy(all) - each_bits / sum_of(all)) / portable_log2(turns));
  }

  [[nodiscard]] bool has_fractions(std::size_t count, std::size_t column) const {
    const KindHistogram& kinds = readings_[count - 1].columns[column];
    double fractions = 0.0;
    for (std::size_t kind = 0; kind < kKinds; kind += 2) {
      if (says_something(kind)) fractions += kinds[kind];
    }
    return fractions > 0.0;
  }

  // Each first float of a point at least as large as the one before.
  [[nodiscard]] bool is_rising(std::size_t count) const {
    float before = -std::numeric_limits<float>::infinity();
    bool rises = true;
    for_each_float([&](std::size_t i) {
      if (i % count != 0) return;
      const float value = float_at(bytes_, i);
      rises = rises && value >= before;
      before = value;
    });
    return rises;
  }

  // A return lies on an axis to the last bit once in a turn, if ever; here more than one in 50
  // does.
  [[nodiscard]] bool has_lone_numbers(std::size_t count) const {
    std::size_t points = 0;
    std::size_t lone = 0;
    for_each_float([&](std::size_t i) {
      if (i % count != 0 || i + 2 >= size()) return;
      int zeros = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) zeros += float_at(bytes_, i + axis) == 0.0F;
      ++points;
      lone += zeros == 2 ? 1 : 0;
    });
    return 50 * lone > points;
  }

  std::span<const std::byte> bytes_;
  std::vector<std::pair<std::size_t, std::size_t>> kinds_;  // index and kind of each float
  std::vector<Reading> readings_;                           // of 1, 2, ... floats a point
};

constexpr std::size_t kFewestFloats = 4096;  // fewer are too few to tell

bool are_alike(const FloatReadings& readings, std::size_t count, std::size_t multiple) {
  return readings.divergence(count, multiple) < 0.1 || readings.follow_each_other(count, multiple);
}

bool are_unlike(const FloatReadings& readings, std::size_t count, std::size_t multiple) {
  return readings.divergence(count, multiple) > 0.45 &&
         !readings.follow_each_other(count, multiple);
}

// A point of a larger count, taken for several.
bool is_torn(const FloatReadings& readings, std::size_t count) {
  for (std::size_t multiple = 2 * count; multiple <= kMostFloats; multiple += count) {
    if (are_unlike(readings, count, multiple)) return true;
  }
  return false;
}

// Points of a smaller count that fits, several of them taken for one.
bool is_repetition(const FloatReadings& readings, FloatCounts fitting, std::size_t count) {
  for (std::size_t part = kLeastFloats; 2 * part <= count; ++part) {
    const bool is_part = count % part == 0 && (fitting & only(part)) != 0;
    if (is_part && are_alike(readings, part, count)) return true;
  }
  return false;
}

constexpr std::size_t kLeastColumns = 3;
constexpr std::size_t kMostColumns = 64;

Error bad_columns(const std::string& what) {
  return {ErrorCode::kBadValue,
          concat("columns: ", what,
                 ", expected how many floats a point has (3 to 64) or their names with x, y and z "
                 "among them, such as x y z intensity ring")};
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

FloatCounts dividing_counts(std::size_t size) {
  FloatCounts counts = 0;
  for (std::size_t count = kLeastFloats; count <= kMostFloats; ++count) {
    if (size % (count * sizeof(float)) == 0) counts |= only(count);
  }
  return counts;
}

FloatCounts fitting_counts(std::span<const std::byte> bytes) {
  if (bytes.size() < kFewestFloats * sizeof(float)) return kAnyCount;
  const FloatReadings readings(bytes);
  FloatCounts counts = 0;
  for (std::size_t count = kLeastFloats; count <= kMostFloats; ++count) {
    const bool fits = !readings.is_beaten(count) && !readings.is_no_point(count) &&
                      !is_torn(readings, count) && !is_repetition(readings, counts, count) &&
                      readings.begins_with_coordinates(count);
    if (fits) counts |= only(count);
  }
  return counts;
}

bool is_refuted(std::span<const std::byte> bytes, std::size_t count) {
  const bool can_tell = bytes.size() >= kFewestFloats * sizeof(float) && count <= kMostFloats;
  return can_tell && FloatReadings(bytes).is_beaten(count);
}

std::string counts_text(FloatCounts counts) {
  std::string text;
  for (std::size_t count = kLeastFloats; count <= kMostFloats; ++count) {
    if ((counts & only(count)) == 0) continue;
    text += concat((text.empty() ? "" : " or "), count);
  }
  return text.empty() ? "none" : text;
}

Result<std::size_t> the_one_count(FloatCounts fitting, FloatCounts dividing) {
  if (fitting == 0) {
    return Error{ErrorCode::kUnsupportedFormat,
                 "no layout of 3 to 10 float32 a point that begins with x y z fits. Name the "
                 "columns with `columns`, or convert the scans to binary PCD"};
  }
  const FloatCounts both = fitting & dividing;
  if (std::has_single_bit(both)) return static_cast<std::size_t>(std::countr_zero(both));
  if (both != 0) {
    return Error{
        ErrorCode::kUnsupportedFormat,
        counts_text(both) +
            " floats a point fit the file. Set the number with `columns`, for example columns: 4"};
  }
  return Error{ErrorCode::kTruncatedScan, concat("found no whole number of points; ",
                                                 counts_text(fitting), " float32 a point fit")};
}

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
  if (words.size() > kMostColumns) return bad_columns(concat("found ", words.size(), " names"));
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
                      concat("found ", file.bytes.size(), " bytes, expected a multiple of ",
                             point_size, " (float32 ", to_text(columns), ")"),
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
      return file.error(
          ErrorCode::kUnsupportedFormat,
          concat("found a coordinate beyond 100 km with float32 ", to_text(columns),
                 ". Name the columns with `columns`, or convert the scan to binary PCD"),
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
