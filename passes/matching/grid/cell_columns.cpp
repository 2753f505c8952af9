#include "passes/matching/grid/cell_columns.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sightline {
namespace {

constexpr std::size_t kMostColumnsPerCell = 8;

// From the lowest to the highest.
struct Bounds {
  std::int64_t low = std::numeric_limits<std::int64_t>::max();
  std::int64_t high = std::numeric_limits<std::int64_t>::min();

  void include(std::int64_t value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(high - low) + 1; }
};

// Whether the numbers of a column hold it.
bool is_told(const Bounds& height) {
  return std::in_range<std::int16_t>(height.low) && std::in_range<std::uint16_t>(height.size());
}

}  // namespace

CellColumns::CellColumns(std::span<const CellKey> keys) {
  if (keys.empty()) return;
  Bounds x, y;
  for (const CellKey& key : keys) {
    x.include(key.x);
    y.include(key.y);
  }
  const std::size_t most = kMostColumnsPerCell * keys.size();
  if (x.size() > most || y.size() > most / x.size()) return;
  const auto column_of = [&](const CellKey& key) {
    return static_cast<std::size_t>(key.y - y.low) * x.size() +
           static_cast<std::size_t>(key.x - x.low);
  };
  std::vector<Bounds> heights(x.size() * y.size());
  for (const CellKey& key : keys) heights[column_of(key)].include(key.z);
  std::vector<KernelColumn> columns;
  columns.reserve(heights.size());
  std::size_t record_count = 0;
  for (const Bounds& height : heights) {
    const bool has_cells = height.low <= height.high;
    if (has_cells && !is_told(height)) return;
    columns.push_back({static_cast<std::uint32_t>(record_count),
                       static_cast<std::int16_t>(has_cells ? height.low : 0),
                       static_cast<std::uint16_t>(has_cells ? height.size() : 0)});
    record_count += columns.back().size_z;
    if (!std::in_range<std::uint32_t>(record_count)) return;
  }
  records_.assign(record_count, 0);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const KernelColumn& column = columns[column_of(keys[i])];
    records_[column.first + static_cast<std::size_t>(keys[i].z - column.low_z)] =
        static_cast<std::int32_t>(i) + 1;
  }
  columns_ = std::move(columns);
  low_x_ = static_cast<std::int32_t>(x.low);
  low_y_ = static_cast<std::int32_t>(y.low);
  size_x_ = static_cast<std::uint32_t>(x.size());
  size_y_ = static_cast<std::uint32_t>(y.size());
}

}  // namespace sightline
