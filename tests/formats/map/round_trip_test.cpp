#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/site_columns.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::string csv(const Table& table) { return format_table(table, TableFormat::kCsv); }

TEST(MapFile, GivesBackEveryArtifactButForTheRoundingOfNds) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CompiledMap map =
        random_map({.seed = seed, .site_count = 60, .nd_count = 80, .has_columns = seed % 2 == 0});
    const CompiledMap back = value_of(read_map(encode_map(map)));
    for (const char* name : {"sites", "predicted", "ranges", "columns"}) {
      EXPECT_EQ(csv(*dump(back, name)), csv(*dump(map, name)));
    }
    EXPECT_EQ(csv(dump(back)), csv(dump(map)));
    EXPECT_EQ(csv(dump(back.sensor)), csv(dump(map.sensor)));
    EXPECT_EQ(back.model, map.model);
    EXPECT_EQ(back.trajectory, map.trajectory);
    EXPECT_EQ(back.measurement.offsets.size(), 2u);
    EXPECT_EQ(back.measurement.localization_scans, "odd");
    EXPECT_EQ(back.measurement.localizer, map.measurement.localizer);
    EXPECT_EQ(back.model.localizer, map.model.localizer);
    EXPECT_EQ(back.measurement.coarse_cells, 2u);
    EXPECT_EQ(back.measurement.leaf_m, 0.5);
    ASSERT_EQ(back.ndt.nds.size(), map.ndt.nds.size());
    for (std::size_t i = 0; i < map.ndt.nds.size(); ++i) {
      const Nd& stored = back.ndt.nds[i];
      const Nd& exact = map.ndt.nds[i];
      EXPECT_EQ(stored.key, exact.key);
      EXPECT_EQ(stored.point_count, exact.point_count);
      EXPECT_LE((stored.mean_m - exact.mean_m).cwiseAbs().maxCoeff(), 3.1e-8);
      EXPECT_LE((stored.covariance_m2 - exact.covariance_m2).cwiseAbs().maxCoeff(),
                6e-8 * exact.covariance_m2.cwiseAbs().maxCoeff());
    }
  }
}

TEST(MapFile, CarriesTheNameOfItsWorldAndNothingOfALocalOne) {
  CompiledMap map = random_map({.seed = 3});
  const std::vector<std::byte> local = encode_map(map);
  EXPECT_EQ(read_map(local)->world, "local");
  map.world = "utm:32N";
  const std::vector<std::byte> named = encode_map(map);
  EXPECT_EQ(read_map(named)->world, "utm:32N");
  EXPECT_NE(named, local);
  for (const std::string& name : {std::string(), std::string("utm 32"), std::string(65, 'u')}) {
    map.world = name;
    EXPECT_FALSE(validate(map)) << name;
  }
}

TEST(MapFile, CarriesWhatScansDoNotConstrainAndWhatWasContradicted) {
  CompiledMap map = random_map({.seed = 3});
  const std::vector<std::byte> without = encode_map(map);
  map.trajectory->unconstrained = {
      {3, 40, 36.0, {true, false, true, Substitute::kConstantSpeed}, 1.8, {1, 2, 3}, {4, 5, 6}},
      {50, 70, 20.0, {false, true, false, Substitute::kGivenPoses}, {}, {7, 8, 9}, {1, 1, 1}}};
  map.notices = {{"given-poses-disagree", "they disagree", 5, 113, 114, 69.1, "m"},
                 {"unlike-profile", "another sensor", 1, 0, 0, 0.0, ""}};
  const std::vector<std::byte> file = encode_map(map);
  EXPECT_NE(file, without);
  const CompiledMap back = value_of(read_map(file));
  EXPECT_EQ(back.trajectory, map.trajectory);
  EXPECT_EQ(back.notices, map.notices);
  map.trajectory->unconstrained.clear();
  map.notices.clear();
  EXPECT_EQ(encode_map(map), without);
  const CompiledMap older = value_of(read_map(without));
  EXPECT_TRUE(older.trajectory->unconstrained.empty());
  EXPECT_TRUE(older.notices.empty());
}

TEST(MapFile, CarriesColumnsOfSitesInTheOrderOfTheirNames) {
  CompiledMap map = random_map({.seed = 3, .has_columns = true});
  const std::vector<std::byte> file = encode_map(map);
  const CompiledMap back = value_of(read_map(file));
  ASSERT_EQ(back.columns.size(), 2u);
  EXPECT_EQ(back.columns[0].name, "clearance_m");
  EXPECT_EQ(back.columns[0].unit, "m");
  EXPECT_EQ(back.columns[0].values, map.columns[0].values);
  EXPECT_EQ(back.columns[1].values, map.columns[1].values);
  EXPECT_EQ(back.columns[1].steps, map.columns[1].steps);
  std::swap(map.columns[0], map.columns[1]);
  EXPECT_FALSE(validate(map)) << "names do not ascend";
  std::swap(map.columns[0], map.columns[1]);
  map.columns[1].values.pop_back();
  EXPECT_FALSE(validate(map)) << "of fewer sites";
  map.columns.clear();
  EXPECT_LT(encode_map(map).size(), file.size());
}

TEST(MapFile, RefusesAColumnThatIsNotTheOneItNames) {
  CompiledMap map = random_map({.seed = 3, .has_columns = true});
  const ContainerParts whole = parts_of(map);
  const auto is_column = [](const BlockParts& section) { return section.name == "column.kind"; };
  ContainerParts other = whole;
  std::ranges::find_if(other.sections, is_column)->raw[0] ^= std::byte{1};
  EXPECT_EQ(read_map(assemble(other)).error().code, ErrorCode::kDigestMismatch);
  ContainerParts without = whole;
  std::erase_if(without.sections, is_column);
  EXPECT_EQ(read_map(assemble(without)).error().code, ErrorCode::kInvalidArtifact);
  ContainerParts as_floats = whole;
  std::ranges::find_if(as_floats.sections, is_column)->version = kColumnSectionVersion;
  EXPECT_EQ(read_map(assemble(as_floats)).error().code, ErrorCode::kBadLayer);
}

TEST(MapFile, TakesAByteASiteForAColumnOfSteps) {
  CompiledMap map = random_map({.seed = 3, .site_count = 1000, .has_columns = true});
  const std::vector<BlockParts> sections = parts_of(map).sections;
  const auto kind = std::ranges::find(sections, "column.kind", &BlockParts::name);
  ASSERT_NE(kind, sections.end());
  EXPECT_EQ(kind->raw.size(), 1000U);
  SiteColumn column = map.columns[1];
  EXPECT_TRUE(decode_column(kind->raw, 1000, column).has_value());
  EXPECT_EQ(column.values, map.columns[1].values);
  column.steps.pop_back();
  EXPECT_EQ(decode_column(kind->raw, 1000, column).error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(decode_column(kind->raw, 999, column).error().code, ErrorCode::kBadLayer);
}

TEST(MapFile, CarriesTheViewOfItsSensorAndNothingOfAFullTurn) {
  CompiledMap map = random_map({.seed = 3});
  const std::vector<std::byte> round = encode_map(map);
  EXPECT_EQ(read_map(round)->sensor.azimuth_view_deg, 360.0);
  map.sensor.azimuth_view_deg = 70.4;
  const std::vector<std::byte> ahead = encode_map(map);
  EXPECT_EQ(read_map(ahead)->sensor.azimuth_view_deg, 70.4);
  EXPECT_NE(ahead, round);
  map.sensor.azimuth_view_deg = 400.0;
  EXPECT_FALSE(validate(map));
}

TEST(MapFile, OfTheSameMapIsTheSameBytesAlsoAfterReading) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 3}));
  EXPECT_EQ(encode_map(random_map({.seed = 3})), file);
  EXPECT_EQ(encode_map(value_of(read_map(file))), file);
}

TEST(MapFile, ThatDiffersInOneNumberAnywhereHasAnotherRootDigest) {
  const CompiledMap map = random_map({.seed = 4});
  const auto digest_of = [](const CompiledMap& changed) {
    return verify_map(encode_map(changed))->root_digest;
  };
  const Digest before = digest_of(map);
  CompiledMap other = map;
  other.release += 1;
  EXPECT_NE(digest_of(other), before);
  other = map;
  other.predicted.mean_m[5] += 1e-12;
  EXPECT_NE(digest_of(other), before);
  other = map;
  other.ndt.nds.back().point_count += 1;
  EXPECT_NE(digest_of(other), before);
  other = map;
  other.ndt.nds.pop_back();
  EXPECT_NE(digest_of(other), before);
}

TEST(MapFile, WithoutItsModelKeepsItsRootDigest) {
  CompiledMap map = random_map({.seed = 5});
  const Result<MapSummary> whole = verify_map(encode_map(map));
  map.model.bytes.clear();
  const std::vector<std::byte> file = encode_map(map);
  const Result<MapSummary> stripped = verify_map(file);
  ASSERT_TRUE(whole && stripped);
  EXPECT_EQ(whole->root_digest, stripped->root_digest);
  EXPECT_LT(stripped->file_size, whole->file_size);
  EXPECT_EQ(failure_of(model_of(value_of(read_map(file)).model)).code, ErrorCode::kBadLayer);
}

TEST(MapFile, IsReadFromDiskAndFromUnalignedMemory) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 6}));
  const std::filesystem::path path = scratch_folder() / "read.slmap";
  ASSERT_TRUE(write_file_atomically(path, file, IfExists::kReplace));
  EXPECT_EQ(value_of(verify_map(path)).file_size, file.size());
  std::vector<std::byte> shifted(1);
  shifted.insert(shifted.end(), file.begin(), file.end());
  EXPECT_TRUE(read_map(std::span<const std::byte>(shifted).subspan(1)));
}

TEST(MapFile, ThatIsNotThereIsSaidSo) {
  const Error error = failure_of(read_map(std::filesystem::path("/nowhere/at/all.slmap")));
  EXPECT_EQ(error.code, ErrorCode::kFileNotFound);
  EXPECT_EQ(error.file, "/nowhere/at/all.slmap");
}

TEST(CompiledMap, DumpsOnlyWhatItHas) {
  CompiledMap map = random_map({.seed = 7});
  for (const char* name : {"nds", "sites", "predicted", "ranges", "factors"}) {
    EXPECT_TRUE(dump(map, name));
  }
  map.factors = {};
  EXPECT_EQ(dump(map, "factors").error().code, ErrorCode::kBadLayer);
  // Its model is made up.
  EXPECT_EQ(dump(map, "model").error().code, ErrorCode::kBadLayer);
  EXPECT_EQ(failure_of(dump(map, "weather")).code, ErrorCode::kUnknownName);
}

TEST(CompiledMap, OfArtifactsThatDisagreeIsInvalid) {
  const auto expect_invalid = [](CompiledMap map) {
    EXPECT_EQ(failure_of(validate(map)).code, ErrorCode::kInvalidArtifact);
  };
  const CompiledMap map = random_map({.seed = 8});
  ASSERT_TRUE(validate(map));
  CompiledMap other = map;
  other.ranges.looks.back().range_m += 1.0;
  expect_invalid(other);
  other = map;
  other.sites.frame.origin_world_m.x() += 64.0;
  expect_invalid(other);
  other = map;
  other.sites.sites.pop_back();
  expect_invalid(other);
  other = map;
  other.reach_m = 2.0 * map.ndt.tile_m;
  expect_invalid(other);
  other = map;
  other.model.bytes[0] ^= std::byte{1};
  expect_invalid(other);
}

}  // namespace
}  // namespace sightline
