#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "formats/base/result.h"

// How many floats a point has in a file without a header, from the floats themselves.

namespace sightline {

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

}  // namespace sightline
