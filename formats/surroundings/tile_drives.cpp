#include "formats/surroundings/tile_drives.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace sightline {
namespace {

Error invalid_row(const std::string& message, std::size_t row) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("row ", row)};
}

auto place_of(const TileDrive& row) { return std::tuple(row.tile.x, row.tile.y, row.drive); }

}  // namespace

std::string day_of(std::int64_t stamp_ns) {
  // No clock of a vehicle shows 1973 (passes/ingest/join_drives.cpp).
  constexpr std::int64_t kEarliestClock_ns = 100'000'000'000'000'000;
  if (stamp_ns < kEarliestClock_ns) return "";
  const std::chrono::sys_time<std::chrono::nanoseconds> time{std::chrono::nanoseconds(stamp_ns)};
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(time)};
  char text[32];
  std::snprintf(text, sizeof text, "%04d-%02u-%02u", static_cast<int>(day.year()),
                static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()));
  return text;
}

Result<void> validate(const TileDrives& tiles) {
  if (!std::isfinite(tiles.tile_m) || tiles.tile_m <= 0.0) {
    return Error{ErrorCode::kInvalidArtifact, "the edge of its tiles is not above 0 m"};
  }
  for (const MappedDrive& drive : tiles.drives) {
    if (!drive.name.empty() && drive.begin_ns <= drive.end_ns) continue;
    return Error{ErrorCode::kInvalidArtifact, "a drive has no name, or ends before it begins", "",
                 concat("drive '", drive.name, "'")};
  }
  for (std::size_t i = 0; i < tiles.rows.size(); ++i) {
    const TileDrive& row = tiles.rows[i];
    if (row.drive >= tiles.drives.size() ||
        (row.scan_count == 0 && row.confirming_scan_count == 0)) {
      return invalid_row("found a drive that is unknown, or that has no scans there", i);
    }
    if (i > 0 && place_of(tiles.rows[i - 1]) >= place_of(row)) {
      return invalid_row("rows are not ascending by tile and drive", i);
    }
  }
  return {};
}

Table dump(const TileDrives& tiles) {
  Table table{"tile-drives",
              {"tile_x", "tile_y", "drive", "day", "scan_count", "confirming_scan_count"},
              {},
              {}};
  table.facts.emplace_back("tile_m", tiles.tile_m);
  for (const TileDrive& row : tiles.rows) {
    const MappedDrive& drive = tiles.drives[row.drive];
    table.rows.push_back({static_cast<std::int64_t>(row.tile.x),
                          static_cast<std::int64_t>(row.tile.y), drive.name, day_of(drive.begin_ns),
                          static_cast<std::int64_t>(row.scan_count),
                          static_cast<std::int64_t>(row.confirming_scan_count)});
  }
  return table;
}

void decode_version_1(ByteReader& reader, TileDrives& tiles) {
  constexpr std::size_t kRowSize = 4 * sizeof(std::uint32_t);
  reader.get(tiles.tile_m);
  decode(reader, tiles.drives);
  tiles.rows.resize(reader.get_count(kRowSize));
  for (TileDrive& row : tiles.rows) {
    decode(reader, row.tile);
    reader.get(row.drive);
    reader.get(row.scan_count);
  }
}

}  // namespace sightline
