#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

// An array of rows of `per_row` numbers of `width` bytes (1, 2, 4 or 8), little-endian.
struct ArrayShape {
  std::uint64_t rows = 0;
  std::uint32_t per_row = 1;
  std::uint32_t width = 1;
  [[nodiscard]] std::uint64_t size() const { return rows * per_row * width; }
};

// Appends the differences from row to row (the first from 0, modulo 2^(8 width)) as planes: of each
// number of a row, the lowest byte of all rows, then the next. What changes little becomes zeros
// that Zstandard packs well.
void append_planes(std::span<const std::byte> array, const ArrayShape& shape,
                   std::vector<std::byte>& planes);
// Back into `array`; both have shape.size() bytes.
void from_planes(std::span<const std::byte> planes, const ArrayShape& shape,
                 std::span<std::byte> array);

}  // namespace sightline
