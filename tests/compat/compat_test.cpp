#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "compiler/base/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/reader.h"

namespace sightline {
namespace {

const std::string kFolder = std::string(SIGHTLINE_COMPAT) + "/";

// What follows from the stored numbers by arithmetic is not what a file promises.
Table stored_columns(Table table) {
  constexpr std::size_t kStoredNdColumns = 13;  // up to cov_zz_m2; eigenvalues follow from these
  if (table.name != "nds") return table;
  table.columns.resize(kStoredNdColumns);
  for (std::vector<Cell>& row : table.rows) row.resize(kStoredNdColumns);
  return table;
}

// Without what dump has learnt to say since: facts and columns that the old text does not name.
Table as_told_then(Table table, const std::string& then) {
  const auto is_new = [&](const std::string& name, char before, char after) {
    return then.find(before + name + after) == std::string::npos;
  };
  std::erase_if(table.facts, [&](const auto& fact) { return is_new(fact.first, ' ', ':'); });
  for (std::size_t column = table.columns.size(); column-- > 1;) {
    const bool is_last = column + 1 == table.columns.size();
    if (!is_new(table.columns[column], ',', is_last ? '\n' : ',')) continue;
    const auto place = static_cast<std::ptrdiff_t>(column);
    table.columns.erase(table.columns.begin() + place);
    for (std::vector<Cell>& row : table.rows) row.erase(row.begin() + place);
  }
  return table;
}

// map_1_0.slmap was written by the first program that wrote maps, and the tables beside it were
// dumped by it; map_1_1.slmap holds the same map. None of these files is ever written again; a new
// version adds its own.
class EveryVersion : public testing::TestWithParam<const char*> {
 protected:
  std::filesystem::path path() const { return kFolder + "map_" + GetParam() + ".slmap"; }
};

TEST_P(EveryVersion, ReadsAndSaysWhatItSaidThen) {
  const Result<CompiledMap> map = read_map(path());
  ASSERT_TRUE(map) << to_string(map.error());
  for (const char* name : {"nds", "sites", "predicted", "ranges"}) {
    const Result<std::string> expected = read_text_file(kFolder + "map_1_0_" + name + ".csv");
    ASSERT_TRUE(expected) << to_string(expected.error());
    const Table table = as_told_then(stored_columns(*dump(*map, name)), *expected);
    EXPECT_EQ(format_table(table, TableFormat::kCsv), *expected) << name;
  }
}

TEST_P(EveryVersion, HasTheRootDigestItHadThenAlsoWhenWrittenAgain) {
  constexpr const char* kRoot = "c3039e09627030878c83b09c5442a4c9948200d831045b90e7c0fc16ab23d7a2";
  const Result<MapSummary> summary = verify_map(path());
  ASSERT_TRUE(summary) << to_string(summary.error());
  EXPECT_EQ(to_hex(summary->root_digest), kRoot);
  std::string version = GetParam();
  std::ranges::replace(version, '_', '.');
  EXPECT_EQ(summary->format, version);
  // Digests are over raw bytes, so a later zstd that packs otherwise changes none.
  EXPECT_EQ(to_hex(verify_map(encode_map(*read_map(path())))->root_digest), kRoot);
}

TEST_P(EveryVersion, AnswersAVehicle) {
  const Result<MapReader> reader = MapReader::open(path().string());
  ASSERT_TRUE(reader) << to_string(reader.error());
  const std::array<double, 3> origin_m = reader->info().origin_world_m;
  const Result<CompiledMap> map = read_map(path());
  ASSERT_TRUE(map);
  for (std::uint32_t site = 0; site < map->sites.sites.size(); ++site) {
    const Eigen::Vector3d& p_m = map->sites.sites[site].p_map_m;
    const Result<RangeAnswer> answer = reader->observation_range(
        {origin_m[0] + p_m.x(), origin_m[1] + p_m.y(), origin_m[2] + p_m.z()}, 0.25);
    ASSERT_TRUE(answer) << to_string(answer.error());
    EXPECT_EQ(answer->site, site);
    EXPECT_EQ(answer->range_m, map->ranges.range_m(site, 1));
  }
}

INSTANTIATE_TEST_SUITE_P(Compat, EveryVersion, testing::Values("1_0", "1_1"));

}  // namespace
}  // namespace sightline
