#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {

// How many floats a point has in a file without a header, from the floats themselves.

constexpr std::size_t kLeastFloats = 3;  // a point
constexpr std::size_t kMostFloats = 10;

// A set of counts: bit 4 is set where 4 floats a point fit.
using FloatCounts = std::uint32_t;
constexpr FloatCounts only(std::size_t count) { return FloatCounts{1} << count; }
constexpr FloatCounts kAnyCount = only(kMostFloats + 1) - only(kLeastFloats);

// Counts from 3 to 10 with which `size` bytes are whole points.
FloatCounts dividing_counts(std::size_t size);

// Counts from 3 to 10 with which the floats make sense as points that begin with x, y and z. All of
// them where there are too few floats to tell (4096).
FloatCounts fitting_counts(std::span<const std::byte> bytes);

// Whether the floats have another count, whatever anybody says. Never so for the one they have.
bool is_refuted(std::span<const std::byte> bytes, std::size_t count);

// The one that is in both sets. Errors, without a file: unsupported-format (none fits, or several),
// truncated-scan (what fits does not divide).
Result<std::size_t> the_one_count(FloatCounts fitting, FloatCounts dividing);

// "4 or 8".
std::string counts_text(FloatCounts counts);

// What the floats of a point are, in a file that does not say it itself (.bin).
struct FloatColumns {
  std::size_t count = 4;  // floats a point
  std::array<std::size_t, 3> position = {0, 1, 2};
  std::optional<std::size_t> intensity = 3;
  std::optional<std::size_t> time;

  bool operator==(const FloatColumns&) const = default;
};

// From how many there are ("5": x y z, then the intensity; the rest is left out), or from their
// names apart by blanks or commas ("x y z intensity ring time"): x, y and z, a usual name of the
// intensity and of a point's time; what has another name is left out. Error: bad-value.
Result<FloatColumns> parse_float_columns(std::string_view text);
FloatColumns columns_of_count(std::size_t count);  // 3 or more

// Their names, as parse_float_columns reads them; "_" stands for what is left out.
std::string to_text(const FloatColumns& columns);

// Float32 without a header, such as KITTI's four floats a point. Without `given` their number is
// found from the floats. Errors: those of parse_point_cloud.
Result<PointCloudFile> parse_float_bin(const FileBytes& file,
                                       const std::optional<FloatColumns>& given);

// Counts of floats a point that fit; of several only nuScenes' five where the name is one of theirs
// (.pcd.bin).
FloatCounts fitting_counts(const FileBytes& file);

}  // namespace sightline
