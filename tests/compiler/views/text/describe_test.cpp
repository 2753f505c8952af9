#include "compiler/views/text/describe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Describe, TellsSitesRangesPromisesAndModel) {
  const CompiledMap map = random_map({.seed = 1});
  const std::string text = describe(map);
  EXPECT_THAT(text, HasSubstr("40, every 1 m, in 2 runs of 38 m together"));
  EXPECT_THAT(text, HasSubstr("limit 0.1 m"));
  EXPECT_THAT(text, HasSubstr("limit 0.25 m"));
  EXPECT_THAT(text, HasSubstr("none: figures of"));
  EXPECT_THAT(text, HasSubstr("95.0 %"));
  EXPECT_THAT(text, HasSubstr("unmet"));
  EXPECT_THAT(text, HasSubstr("tree_count"));
  EXPECT_THAT(text, HasSubstr("even scans"));
  EXPECT_THAT(text, HasSubstr(to_hex(map.model.digest)));
}

TEST(Describe, ShowsFiguresOfTheModelByTheirStoredNumbers) {
  CompiledMap map = random_map({.seed = 1});
  map.model.card = {{"range_10_m_r_squared", "text"}, {"importance_slope_m", "0.5"}};
  map.model.figures = {{0, CardFigureKind::kRSquared, "10", 0.256}};
  const std::string text = describe(map);
  EXPECT_THAT(text, HasSubstr("R^2 at 10 m            0.26"));
  EXPECT_THAT(text, HasSubstr("importance_slope_m     0.5"));
}

TEST(Describe, CountsEverySiteInTheHistogramOfALimit) {
  CompiledMap map = random_map({.seed = 2, .site_count = 4, .limits_m = {0.1}});
  map.ranges.range_index = {0, 0, 0, 1};
  map.ranges.flags = {0, 0, 0, 0};
  EXPECT_THAT(describe(map),
              HasSubstr("   10 m       3   75.0 %  ##############################\n"));
  EXPECT_THAT(describe(map), HasSubstr("   50 m       0    0.0 %  \n"));
}

TEST(Describe, TellsWhatTheFileIsMadeOf) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 3}));
  const std::string text = describe(*verify_map(file));
  EXPECT_THAT(text, HasSubstr(std::to_string(file.size()) + " bytes"));
  for (const char* part : {"ndt", "range", "error-model", "manifest", "directory", "root digest"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST(DescribeDrives, SaysTheDayOfEachDriveAndHowManyTilesAreFromIt) {
  constexpr std::int64_t kMay4_ns = 1'777'852'800'000'000'000;
  const TileDrives tiles{64.0,
                         {{"monday", kMay4_ns, kMay4_ns + 1}, {"test", 0, 5}, {"later", 6, 7}},
                         {{{0, 0}, 0, 3, 0},
                          {{0, 0}, 2, 0, 8},
                          {{0, 1}, 0, 1, 0},
                          {{0, 1}, 1, 2, 0},
                          {{0, 1}, 2, 2, 1},
                          {{0, 2}, 2, 0, 9}}};
  EXPECT_EQ(describe_drives(tiles),
            "drives\n"
            "  monday                 2026-05-04, in 2 tiles\n"
            "  test                   day not known, in 1 tiles\n"
            "  later                  day not known, in 1 tiles, nothing new in 3\n");
}

}  // namespace
}  // namespace sightline
