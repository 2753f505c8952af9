#include "formats/foreign/clouds/floats/float_counts.h"

#include <bit>

namespace sightline {
namespace {

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
    text += (text.empty() ? "" : " or ") + std::to_string(count);
  }
  return text.empty() ? "none" : text;
}

Result<std::size_t> the_one_count(FloatCounts fitting, FloatCounts dividing) {
  if (fitting == 0) {
    return Error{ErrorCode::kUnsupportedFormat,
                 "found no points of 3 to 10 float32 each that begin with x y z; name the columns "
                 "with `columns`, or convert the scans to binary PCD"};
  }
  const FloatCounts both = fitting & dividing;
  if (std::has_single_bit(both)) return static_cast<std::size_t>(std::countr_zero(both));
  if (both != 0) {
    return Error{ErrorCode::kUnsupportedFormat,
                 counts_text(both) +
                     " floats a point fit, and which is unknown; say how many there are with "
                     "`columns`, such as columns: 4"};
  }
  return Error{ErrorCode::kTruncatedScan,
               "found no whole number of points; " + counts_text(fitting) + " float32 a point fit"};
}

}  // namespace sightline
