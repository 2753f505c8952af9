#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/repair.h"
#include "formats/reader/map_container.h"
#include "formats/reader/reader.h"
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

// The same map, were it not stored as a small one.
std::vector<std::byte> as_full(CompiledMap map) {
  map.size = MapSize::kFull;
  return encode_map(map);
}

TEST(SmallMap, AnswersAsTheSameNumbersInAFullMap) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const CompiledMap map = small_map(seed);
    const std::vector<std::byte> small = encode_map(map);
    const std::vector<std::byte> full = as_full(map);
    const MapReader a = value_of(MapReader::open(std::span(small), "annealed"));
    const MapReader b = value_of(MapReader::open(std::span(full), "annealed"));
    for (const double limit_m : {0.05, 0.1, 0.3}) {
      for (const Site& site : map.sites.sites) {
        std::array<double, 3> p_m{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const int i = static_cast<int>(axis);
          p_m[axis] = site.p_map_m[i] + map.ndt.frame.origin_world_m[i] + 0.3;
        }
        const RangeAnswer of_small = value_of(a.observation_range(p_m, limit_m));
        const RangeAnswer of_full = value_of(b.observation_range(p_m, limit_m));
        EXPECT_EQ(of_small.site, of_full.site);
        EXPECT_EQ(of_small.range_m, of_full.range_m);
        EXPECT_EQ(of_small.probability, of_full.probability);
        EXPECT_EQ(of_small.mean_error_m, of_full.mean_error_m);
        EXPECT_EQ(of_small.distance_m, of_full.distance_m);
        EXPECT_EQ(of_small.flags, of_full.flags);
        EXPECT_EQ(of_small.reason, of_full.reason);
        const LookAnswer look = value_of(a.look(p_m, limit_m, 60.0));
        EXPECT_EQ(look.probability, value_of(b.look(p_m, limit_m, 60.0)).probability);
      }
    }
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
