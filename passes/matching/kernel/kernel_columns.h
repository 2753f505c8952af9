#pragma once

#include <cstddef>
#include <cstdint>

namespace sightline {

// The cells above one place in the plane: from the cell `low_z` on, size_z follow each other
// upwards, and records[first] is the number of the first one's record.
struct KernelColumn {
  std::uint32_t first;
  std::int16_t low_z;
  std::uint16_t size_z;
};

// Cells by columns, row by row of y from low_y on, each row from low_x on. A cell that is not there
// has record 0.
struct KernelColumns {
  const KernelColumn* columns = nullptr;  // null: cells are given in another way
  const std::int32_t* records = nullptr;
  std::int32_t low_x = 0, low_y = 0;
  std::uint32_t size_x = 0, size_y = 0;
};

namespace {

// So far beyond the first; below it a number too large.
inline std::uint32_t beyond(std::int32_t first, std::int32_t number) {
  return static_cast<std::uint32_t>(number) - static_cast<std::uint32_t>(first);
}

// Null outside of all.
inline const KernelColumn* find_column(const KernelColumns& all, std::int32_t x, std::int32_t y) {
  const std::uint32_t column = beyond(all.low_x, x);
  const std::uint32_t row = beyond(all.low_y, y);
  if (column >= all.size_x || row >= all.size_y) return nullptr;
  return all.columns + std::size_t{row} * all.size_x + column;
}

inline std::int32_t find_record(const KernelColumns& all, std::int32_t x, std::int32_t y,
                                std::int32_t z) {
  const KernelColumn* const column = find_column(all, x, y);
  if (column == nullptr) return 0;
  const std::uint32_t number = beyond(column->low_z, z);
  return number < column->size_z ? all.records[column->first + number] : 0;
}

}  // namespace
}  // namespace sightline
