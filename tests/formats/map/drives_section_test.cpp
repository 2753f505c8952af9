#include "formats/map/drives_section.h"

#include <gtest/gtest.h>

#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/repair.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TileDrives two_drives() {
  return {64.0,
          {{"monday", 1'777'852'800'000'000'000, 1'777'852'900'000'000'000}, {"tuesday", 0, 5}},
          {{{-1, 2}, 0, 3, 0}, {{0, 0}, 0, 0, 4}, {{0, 0}, 1, 7, 2}}};
}

TEST(DrivesSection, IsPartOfAMapAndChangesNoDigestThatAVehicleReliesOn) {
  const CompiledMap bare = random_map({.seed = 3});
  CompiledMap map = bare;
  map.tile_drives = two_drives();
  const std::vector<std::byte> file = encode_map(map);
  const CompiledMap back = value_of(read_map(file));
  EXPECT_EQ(back.tile_drives, map.tile_drives);
  EXPECT_EQ(format_table(*dump(back, "tile-drives"), TableFormat::kCsv),
            "# tile_m: 64\n"
            "tile_x,tile_y,drive,day,scan_count,confirming_scan_count\n"
            "-1,2,monday,2026-05-04,3,0\n"
            "0,0,monday,2026-05-04,0,4\n"
            "0,0,tuesday,,7,2\n");
  const std::vector<std::byte> bare_file = encode_map(bare);
  EXPECT_FALSE(read_map(bare_file)->tile_drives.has_value());
  EXPECT_TRUE(dump(bare, "tile-drives")->rows.empty());
  EXPECT_EQ(verify_map(file)->root_digest, verify_map(bare_file)->root_digest);
  EXPECT_EQ(value_of(recover_map(file)).map.tile_drives, map.tile_drives);
}

TEST(DrivesSection, IsRefusedWhenCutShortAtEveryByte) {
  const std::vector<std::byte> raw = encode_drives(two_drives());
  EXPECT_EQ(*decode_drives(raw, kDrivesSectionVersion, 3), two_drives());
  EXPECT_EQ(decode_drives(raw, kDrivesSectionVersion, 2).error().code, ErrorCode::kBadLayer);
  for (std::size_t size = 0; size < raw.size(); ++size) {
    EXPECT_FALSE(decode_drives(std::span(raw).first(size), kDrivesSectionVersion, 3)) << size;
  }
}

TEST(DrivesSection, DamagedAtAnyByteIsRefusedOrValid) {
  const std::vector<std::byte> raw = encode_drives(two_drives());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    std::vector<std::byte> damaged = raw;
    damaged[i] ^= std::byte{0xff};
    const Result<TileDrives> tiles = decode_drives(damaged, kDrivesSectionVersion, 3);
    EXPECT_TRUE(!tiles || validate(*tiles)) << i;
  }
}

std::vector<std::byte> first_version(const TileDrives& tiles) {
  ByteWriter writer;
  encode(TileDrives{tiles.tile_m, tiles.drives, {}}, writer);
  std::vector<std::byte> raw = writer.take();
  raw.resize(raw.size() - sizeof(std::uint64_t));  // the number of rows
  ByteWriter rows;
  rows.put<std::uint64_t>(tiles.rows.size());
  for (const TileDrive& row : tiles.rows) {
    rows.put(row.tile.x);
    rows.put(row.tile.y);
    rows.put(row.drive);
    rows.put(row.scan_count);
  }
  const std::vector<std::byte> end = rows.take();
  raw.insert(raw.end(), end.begin(), end.end());
  return raw;
}

TEST(DrivesSection, IsReadInItsFirstVersion) {
  TileDrives tiles = two_drives();
  tiles.rows = {{{-1, 2}, 0, 3, 0}, {{0, 0}, 1, 7, 0}};
  const std::vector<std::byte> raw = first_version(tiles);
  EXPECT_EQ(*decode_drives(raw, 1, 2), tiles);
  EXPECT_FALSE(decode_drives(raw, 2, 2)) << "it has no confirming scans";
  EXPECT_TRUE(knows_drives_section(1) && knows_drives_section(2));
  EXPECT_FALSE(knows_drives_section(0) || knows_drives_section(3));
}

TEST(DrivesSection, RefusesRowsOutOfOrderAndDrivesThatAreNone) {
  TileDrives tiles = two_drives();
  std::swap(tiles.rows[1], tiles.rows[2]);
  EXPECT_EQ(validate(tiles).error().code, ErrorCode::kInvalidArtifact);
  tiles = two_drives();
  tiles.rows[2].drive = 2;
  EXPECT_EQ(validate(tiles).error().code, ErrorCode::kInvalidArtifact);
  tiles = two_drives();
  tiles.rows[0].scan_count = 0;
  EXPECT_EQ(validate(tiles).error().code, ErrorCode::kInvalidArtifact);
  tiles = two_drives();
  tiles.drives[0].end_ns = 0;
  EXPECT_EQ(validate(tiles).error().code, ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
