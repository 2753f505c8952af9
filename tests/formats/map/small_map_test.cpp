#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/repair.h"
#include "formats/reader/map_container.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

CompiledMap small_map(std::uint64_t seed) {
  return random_map({.seed = seed,
                     .site_count = 300,
                     .nd_count = 2000,
                     .extent_m = 150.0,
                     .has_columns = true,
                     .size = MapSize::kPromise});
}

TEST(SmallMap, IsReadAsItWasWritten) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const CompiledMap map = small_map(seed);
    const std::vector<std::byte> file = encode_map(map);
    const CompiledMap read = value_of(read_map(file));
    EXPECT_EQ(read.size, MapSize::kPromise);
    EXPECT_EQ(read.predicted.mean_m, map.predicted.mean_m);
    EXPECT_EQ(read.predicted.within_probability, map.predicted.within_probability);
    EXPECT_EQ(encode_map(read), file) << seed;
  }
}

TEST(SmallMap, IsRecoveredStrippedAndVerified) {
  const CompiledMap map = small_map(9);
  const std::vector<std::byte> file = encode_map(map);
  EXPECT_TRUE(verify_map(file));
  EXPECT_EQ(encode_map(value_of(recover_map(file)).map), file);
  const std::vector<std::byte> stripped = value_of(strip_map(file)).file;
  EXPECT_EQ(open_container(stripped)->header.root_digest, open_container(file)->header.root_digest);
  EXPECT_TRUE(verify_map(stripped));
}

TEST(SmallMap, OfAnUnknownSizeIsRefused) {
  CompiledMap map = small_map(2);
  map.size = static_cast<MapSize>(7);
  EXPECT_EQ(failure_of(read_map(encode_map(map))).code, ErrorCode::kBadManifest);
}

TEST(RoundAnswers, ChangesNoChoiceAndKeepsPredictionsValid) {
  CompiledMap map = random_map({.seed = 4, .site_count = 200, .nd_count = 0});
  const CompiledMap before = map;
  round_answers(map);
  EXPECT_TRUE(validate(map));
  EXPECT_EQ(map.ranges.range_index, before.ranges.range_index);
  for (std::size_t i = 0; i < map.predicted.mean_m.size(); ++i) {
    EXPECT_NEAR(map.predicted.mean_m[i], std::min(before.predicted.mean_m[i], kLongestSmallError_m),
                kSmallLength_m / 2);
  }
  for (std::size_t i = 0; i < map.predicted.within_probability.size(); ++i) {
    EXPECT_NEAR(map.predicted.within_probability[i], before.predicted.within_probability[i],
                kSmallShare / 2);
  }
  CompiledMap again = map;
  round_answers(again);
  EXPECT_EQ(again.predicted.mean_m, map.predicted.mean_m);
}

}  // namespace
}  // namespace sightline
