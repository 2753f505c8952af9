#include "formats/map/container/packed_columns.h"

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/map/container/zstd_frame.h"
#include "formats/reader/map_layout.h"

// Packed: the number of columns (u32), of each its numbers in a row and their width in bytes (u32
// each), then the planes of all of them; in one frame.

namespace sightline {
namespace {

constexpr std::uint32_t kMostPackedColumns = 1024;
constexpr std::uint32_t kMostPerRow = std::uint32_t{1} << 20;

Result<std::vector<ArrayShape>> shapes_of(ByteReader& reader, std::uint64_t row_count) {
  const auto count = reader.get<std::uint32_t>();
  if (!reader.ok() || count > kMostPackedColumns) return unreadable_block();
  std::vector<ArrayShape> shapes;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto per_row = reader.get<std::uint32_t>();
    const auto width = reader.get<std::uint32_t>();
    const bool is_width = width == 1 || width == 2 || width == 4 || width == 8;
    if (!reader.ok() || !is_width || per_row > kMostPerRow) return unreadable_block();
    shapes.push_back({row_count, per_row, width});
  }
  return shapes;
}

}  // namespace

std::vector<std::byte> pack_columns(std::span<const std::byte> raw,
                                    std::span<const ArrayShape> columns) {
  ByteWriter head;
  head.put(static_cast<std::uint32_t>(columns.size()));
  for (const ArrayShape& column : columns) {
    head.put(column.per_row);
    head.put(column.width);
  }
  std::vector<std::byte> planes(head.bytes().begin(), head.bytes().end());
  std::uint64_t place = 0;
  for (const ArrayShape& column : columns) {
    append_planes(raw.subspan(place, column.size()), column, planes);
    place += aligned(column.size());
  }
  SIGHTLINE_CHECK(place == raw.size());
  return zstd_frame(planes);
}

Result<std::vector<std::byte>> unpack_columns(std::span<const std::byte> stored,
                                              std::uint64_t row_count, std::uint64_t raw_size) {
  if (row_count > kMostRows || raw_size > kLargestBlock) return unreadable_block();
  constexpr std::uint64_t kMostHead = 4 + 8 * std::uint64_t{kMostPackedColumns};
  SIGHTLINE_ASSIGN(const std::vector<std::byte> planes,
                   bytes_of_frame(stored, raw_size + kMostHead));
  ByteReader reader(planes);
  SIGHTLINE_ASSIGN(const std::vector<ArrayShape> columns, shapes_of(reader, row_count));
  std::vector<std::byte> raw(raw_size);
  std::uint64_t place = 0;
  std::uint64_t at = 4 + 8 * columns.size();
  for (const ArrayShape& column : columns) {
    if (column.size() > planes.size() - at || place > raw_size ||
        column.size() > raw_size - place) {
      return unreadable_block();
    }
    from_planes(std::span(planes).subspan(at, column.size()), column,
                std::span(raw).subspan(place, column.size()));
    at += column.size();
    place += aligned(column.size());
  }
  if (at != planes.size() || place != raw_size) return unreadable_block();
  return raw;
}

}  // namespace sightline
