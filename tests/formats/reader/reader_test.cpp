#include "formats/reader/reader.h"
#include "formats/reader/site_protection.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <thread>
#include <tuple>

#include "formats/base/random.h"
#include "formats/grid/point_grid.h"
#include "formats/map/container/container_writer.h"
#include "formats/map/manifest.h"
#include "formats/map/map_writer.h"
#include "formats/map/site_columns.h"
#include "formats/reader/look_up.h"
#include "formats/reader/map_checks.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"
#include "tests/formats/map/resealed.h"
#include "tests/formats/reader/allocation_count.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using Position = std::array<double, 3>;

Position world(const CompiledMap& map, const Eigen::Vector3d& p_map_m) {
  const Eigen::Vector3d p_m = p_map_m + map.sites.frame.origin_world_m;
  return {p_m.x(), p_m.y(), p_m.z()};
}

// The definition, read off the artifacts: no tiles, no file.
RangeAnswer brute_force(const CompiledMap& map, const Position& position_world_m, double limit_m) {
  const Eigen::Vector3d p_m =
      Eigen::Vector3d(position_world_m[0], position_world_m[1], position_world_m[2]) -
      map.sites.frame.origin_world_m;
  RangeAnswer answer;
  answer.range_m = map.ranges.looks.back().range_m;
  answer.mean_error_m = std::numeric_limits<double>::infinity();
  double nearest_m = map.reach_m;
  for (std::uint32_t site = 0; site < map.ranges.site_count; ++site) {
    const Eigen::Vector3d& site_m = map.sites.sites[site].p_map_m;
    const double distance_m = (site_m - p_m).norm();
    if (std::abs(site_m.z() - p_m.z()) >= 1.0) continue;
    if (distance_m > nearest_m || (distance_m == nearest_m && answer.site != kNoSite)) continue;
    nearest_m = answer.distance_m = distance_m;
    answer.site = site;
  }
  // The search of everything that is no vehicle says the same.
  const std::optional<NearPoint> by_grid =
      PointGrid(positions_m(map.sites)).nearest_on_level(p_m, map.reach_m);
  EXPECT_EQ(by_grid ? by_grid->index : kNoSite, answer.site);
  std::size_t limit = map.ranges.promises.size();
  while (limit > 0 && map.ranges.promises[limit - 1].limit_m > limit_m) --limit;
  if (limit == 0) answer.flags |= kAnswerTighterLimit;
  if (answer.site == kNoSite) {
    answer.flags |= kAnswerFar;
    return answer;
  }
  std::size_t range = map.ranges.looks.size() - 1;
  if (limit > 0) {
    const std::size_t choice = answer.site * map.ranges.promises.size() + limit - 1;
    range = map.ranges.range_index[choice];
    answer.flags |= map.ranges.flags[choice];
    answer.reason = map.ranges.reasons[choice];
    answer.probability = map.predicted.probability(answer.site, range, limit - 1);
  }
  answer.range_m = map.ranges.looks[range].range_m;
  answer.mean_error_m = map.predicted.mean(answer.site, range);
  return answer;
}

void expect_equal(const RangeAnswer& found, const RangeAnswer& expected) {
  EXPECT_EQ(found.site, expected.site);
  EXPECT_EQ(found.range_m, expected.range_m);
  EXPECT_EQ(found.probability, expected.probability);
  EXPECT_EQ(found.mean_error_m, expected.mean_error_m);
  EXPECT_EQ(found.flags, expected.flags);
  EXPECT_EQ(found.reason, expected.reason);
  if (expected.site != kNoSite) {
    EXPECT_NEAR(found.distance_m, expected.distance_m, 1e-12);
  } else {
    EXPECT_EQ(found.distance_m, expected.distance_m);
  }
}

// Every third map is a small one.
MapSize size_of(std::uint64_t seed) { return seed % 3 == 1 ? MapSize::kPromise : MapSize::kFull; }

TEST(MapReader, AgreesWithBruteForceOverRandomMaps) {
  std::size_t found_count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    CompiledMap map = random_map({.seed = seed,
                                  .site_count = seed % 5 == 0 ? 900 : 200,
                                  .nd_count = 20,
                                  .tile_m = seed % 2 == 0 ? 16.0 : 64.0,
                                  .limits_m = {0.10, 0.20, 0.30},
                                  .size = size_of(seed)});
    map.reach_m = seed % 3 == 0 ? 16.0 : 6.0;
    const std::vector<std::byte> file = encode_map(map);
    const MapReader reader = value_of(MapReader::open(file, "annealed"));
    for (int i = 0; i < 300; ++i) {
      const Position position =
          world(map, {random.uniform(-120.0, 120.0), random.uniform(-120.0, 120.0),
                      random.uniform(-3.0, 3.0)});
      const double limit_m = random.uniform(0.05, 0.4);
      const RangeAnswer expected = brute_force(map, position, limit_m);
      expect_equal(value_of(reader.observation_range(position, limit_m)), expected);
      if (expected.site != kNoSite) ++found_count;
    }
  }
  EXPECT_GT(found_count, 2000u) << "too few places near a site to show anything";
}

LookAnswer brute_force_look(const CompiledMap& map, const Position& position_world_m,
                            double limit_m, double visible_m) {
  RangeAnswer range = brute_force(map, position_world_m, limit_m);
  const auto answer_of = [](const Look& look, const RangeAnswer& numbers) {
    return LookAnswer{{look.range_m, look.return_count, look.even_beyond_m, look.point_count,
                       look.is_by_normals, look.mode == LookMode::kSettle},
                      numbers.probability,
                      numbers.mean_error_m,
                      numbers.distance_m,
                      numbers.flags,
                      numbers.site,
                      numbers.reason};
  };
  const bool is_near = (range.flags & (kAnswerFar | kAnswerTighterLimit)) == 0;
  if (map.looks && is_near) {
    const auto& [predicted, looks, quality, factors] = *map.looks;
    std::size_t limit = looks.promises.size();
    while (looks.promises[limit - 1].limit_m > limit_m) --limit;
    const std::size_t number = looks.range(range.site, limit - 1);
    const Look& look = looks.looks[number];
    RangeAnswer numbers = range;
    numbers.flags = looks.flags_of(range.site, limit - 1);
    numbers.reason = looks.reason(range.site, limit - 1);
    numbers.probability = predicted.probability(range.site, number, limit - 1);
    numbers.mean_error_m = predicted.mean(range.site, number);
    if (look.range_m <= visible_m) return answer_of(look, numbers);
  }
  if (range.range_m > visible_m) {
    range.flags |= kAnswerNotVisible;
    range.reason = Reason::kNone;
    range.probability = 0.0;
    range.range_m = map.ranges.looks.back().range_m;
  }
  return answer_of(every_return(range.range_m), range);
}

TEST(MapReader, NamesTheCheapestLookWithinWhatCanBeSeenAsBruteForceDoes) {
  std::size_t sample_count = 0, hidden_count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    RandomMapOptions options{.seed = seed, .site_count = 200, .nd_count = 20};
    if (seed % 4 == 0) options.looks.clear();
    options.size = size_of(seed);
    const CompiledMap map = random_map(options);
    const std::vector<std::byte> file = encode_map(map);
    const MapReader reader = value_of(MapReader::open(file, "annealed"));
    EXPECT_EQ(reader.info().looks.size(), options.looks.size());
    for (int i = 0; i < 200; ++i) {
      const Position position =
          world(map, {random.uniform(-110.0, 110.0), random.uniform(-110.0, 110.0), 0.0});
      const double limit_m = random.uniform(0.05, 0.4);
      const double seen_m[] = {5.0, 30.0, 90.0, std::numeric_limits<double>::infinity()};
      const double visible_m = seen_m[random.below(4)];
      const LookAnswer expected = brute_force_look(map, position, limit_m, visible_m);
      const LookAnswer found = value_of(reader.look(position, limit_m, visible_m));
      EXPECT_EQ(found.look.range_m, expected.look.range_m);
      EXPECT_EQ(found.look.return_count, expected.look.return_count);
      EXPECT_EQ(found.look.even_beyond_m, expected.look.even_beyond_m);
      EXPECT_EQ(found.look.point_count, expected.look.point_count);
      EXPECT_EQ(found.look.is_by_normals, expected.look.is_by_normals);
      EXPECT_EQ(found.look.settles, expected.look.settles);
      EXPECT_EQ(found.probability, expected.probability);
      EXPECT_EQ(found.mean_error_m, expected.mean_error_m);
      EXPECT_EQ(found.reason, expected.reason);
      EXPECT_EQ(found.flags, expected.flags);
      EXPECT_EQ(found.site, expected.site);
      sample_count += found.look.return_count > 0 ? 1 : 0;
      hidden_count += (found.flags & kAnswerNotVisible) != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(sample_count, 200U) << "too few looks to show anything";
  EXPECT_GT(hidden_count, 100U);
}

MapLook map_look(const Look& look) {
  return {look.range_m,     look.return_count,  look.even_beyond_m,
          look.point_count, look.is_by_normals, look.mode == LookMode::kSettle};
}

bool is_same(const MapLook& a, const MapLook& b) {
  return std::tie(a.range_m, a.return_count, a.even_beyond_m, a.point_count, a.is_by_normals,
                  a.settles) == std::tie(b.range_m, b.return_count, b.even_beyond_m, b.point_count,
                                         b.is_by_normals, b.settles);
}

void expect_plan(const LookPlanAnswer& found, const LookPlan& plan, const LookAnswer& there) {
  Look look;
  look.range_m = there.look.range_m;
  look.return_count = there.look.return_count;
  look.even_beyond_m = there.look.even_beyond_m;
  look.point_count = there.look.point_count;
  look.is_by_normals = there.look.is_by_normals;
  const LookPlan expected = plan_at(plan, look);
  EXPECT_TRUE(is_same(found.first.look, map_look(expected.first)));
  EXPECT_TRUE(is_same(found.second, map_look(expected.second)));
  EXPECT_EQ(found.weights, expected.test.weights);
  EXPECT_EQ(found.constant, expected.test.constant);
  EXPECT_EQ(found.doubt_above, expected.doubt_above);
  EXPECT_TRUE(std::isnan(found.first.probability) && std::isnan(found.first.mean_error_m));
  EXPECT_EQ(found.first.site, there.site);
}

TEST(MapReader, TellsAVehicleThatTracksThePlanAndAnyOtherTheLook) {
  std::size_t plan_count = 0, cheaper_count = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const CompiledMap map =
        random_map({.seed = seed, .site_count = 200, .nd_count = 20, .size = size_of(seed)});
    const std::optional<LookPlan>& plan = map.looks->ranges.plan;
    const std::vector<std::byte> file = encode_map(map);
    const MapReader reader = value_of(MapReader::open(file, "annealed"));
    for (int i = 0; i < 200; ++i) {
      const Position position =
          world(map, {random.uniform(-110.0, 110.0), random.uniform(-110.0, 110.0), 0.0});
      const double limit_m = random.uniform(0.05, 0.4);
      const double visible_m = random.below(2) == 0 ? 90.0 : 200.0;
      const bool is_tracking = random.below(4) > 0;
      const Result<LookAnswer> look = reader.look(position, limit_m, visible_m);
      const Result<LookPlanAnswer> found =
          reader.look_plan(position, limit_m, is_tracking, visible_m);
      ASSERT_TRUE(look && found);
      const bool expects_plan = is_tracking && plan && limit_m >= plan->limit_m &&
                                visible_m == 200.0 &&
                                (look->flags & (kAnswerFar | kAnswerTighterLimit)) == 0;
      ASSERT_EQ(found->has_second, expects_plan);
      if (expects_plan) {
        expect_plan(*found, *plan, *look);
        ++plan_count;
        cheaper_count += found->first.look.point_count < plan->first.point_count ? 1 : 0;
      } else {
        EXPECT_TRUE(is_same(found->first.look, look->look));
        EXPECT_EQ(found->first.probability, look->probability);
        EXPECT_EQ(found->first.flags, look->flags);
      }
    }
  }
  EXPECT_GT(plan_count, 50U) << "too few plans to show anything";
  EXPECT_GT(cheaper_count, 20U);
}

TEST(MapReader, RefusesAPlanWhoseNumbersMakeNoSense) {
  const auto is_accepted = [](const auto& change) {
    CompiledMap map = random_map({.seed = 2});
    change(*map.looks->ranges.plan);
    const std::vector<std::byte> bytes = encode_manifest(map);
    return check_manifest(*flatbuffers::GetRoot<schema::Manifest>(bytes.data())).has_value();
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_accepted([](LookPlan&) {}));
  EXPECT_TRUE(is_accepted([](LookPlan& plan) { plan.doubt_above = kInfinity; })) << "never";
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.doubt_above = kNan; }));
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.test.weights[7] = kInfinity; }));
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.test.constant = kNan; }));
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.second.return_count = 0; }));
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.first.range_m = -1.0; }));
  EXPECT_FALSE(is_accepted([](LookPlan& plan) { plan.limit_m = 0.0; }));
}

TEST(MapReader, NamesNoLookToALocalizerWhoseErrorsWereNotMeasured) {
  const CompiledMap map = random_map({.seed = 7});
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "pcl-ndt"));
  const LookAnswer found = value_of(reader.look(world(map, map.sites.sites[3].p_map_m), 0.25));
  EXPECT_EQ(found.look.range_m, map.ranges.looks.back().range_m);
  EXPECT_EQ(found.look.return_count, 0U);
  EXPECT_TRUE(std::isnan(found.probability));
  EXPECT_NE(found.flags & kAnswerUnknownLocalizer, 0U);
}

TEST(MapReader, FindsASiteJustAcrossABorderOfTilesOnEverySide) {
  CompiledMap map = random_map({.seed = 1, .site_count = 1, .run_count = 1});
  for (const double dx_m : {-5.0, 0.0, 5.0}) {
    for (const double dy_m : {-5.0, 0.0, 5.0}) {
      map.sites.sites[0].p_map_m = {64.0 + dx_m, -64.0 + dy_m, 1.0};
      const std::vector<std::byte> file = encode_map(map);
      const MapReader reader = value_of(MapReader::open(file, "annealed"));
      for (const double ex_m : {-1e-9, 0.0, 1e-9}) {
        const Position position = world(map, {64.0 + ex_m, -64.0 - ex_m, 1.0});
        EXPECT_EQ(reader.observation_range(position, 0.1)->site, 0u) << dx_m << " " << dy_m;
      }
    }
  }
}

TEST(MapReader, TakesTheLowerIdWhereTwoSitesAreEquallyNear) {
  CompiledMap map = random_map({.seed = 1, .site_count = 2, .run_count = 1});
  for (const bool is_swapped : {false, true}) {
    map.sites.sites[is_swapped ? 1 : 0].p_map_m = {-3.0, 0.0, 0.0};
    map.sites.sites[is_swapped ? 0 : 1].p_map_m = {3.0, 0.0, 0.0};
    const std::vector<std::byte> file = encode_map(map);
    const MapReader reader = value_of(MapReader::open(file, "annealed"));
    EXPECT_EQ(reader.observation_range(world(map, {0.0, 0.0, 0.0}), 0.1)->site, 0u);
  }
}

TEST(MapReader, AnswersFromTheLevelOfThePosition) {
  CompiledMap map = random_map({.seed = 1, .site_count = 3, .run_count = 1});
  for (std::size_t site = 0; site < 3; ++site) {
    map.sites.sites[site].p_map_m = {site == 2 ? 2.0 : 0.0, 0.0,
                                     1.8 + 2.75 * static_cast<double>(site)};
  }
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const auto site_at = [&](double z_m) {
    const RangeAnswer answer = *reader.observation_range(world(map, {0.0, 0.0, z_m}), 0.1);
    EXPECT_EQ((answer.flags & kAnswerFar) != 0, answer.site == kNoSite);
    return answer.site;
  };
  EXPECT_EQ(site_at(1.8), 0U);
  EXPECT_EQ(site_at(4.55), 1U);
  EXPECT_EQ(site_at(7.3), 2U);  // 2 m away: the storey below is as near as that
  EXPECT_EQ(site_at(6.4), 2U);  // 0.9 m below its level
  EXPECT_EQ(site_at(5.5), 1U);  // 0.95 m above
  EXPECT_EQ(site_at(5.6), kNoSite);
  EXPECT_EQ(site_at(0.75), kNoSite);
}

TEST(MapReader, FarFromAnySiteAnswersTheLongestRange) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 2}));
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  for (const double far_m : {200.0, -5000.0, 1e7, 1e300}) {
    const RangeAnswer answer = value_of(reader.observation_range({far_m, far_m, 0.0}, 0.25));
    EXPECT_EQ(answer.range_m, 50.0);
    EXPECT_EQ(answer.flags, kAnswerFar);
    EXPECT_EQ(answer.probability, 0.0);
    EXPECT_TRUE(std::isinf(answer.distance_m));
  }
}

std::vector<std::byte> with_reach(const CompiledMap& map, double reach_m) {
  ContainerParts parts = parts_of(map);
  auto* manifest = flatbuffers::GetMutableRoot<flatbuffers::Table>(parts.manifest.data());
  EXPECT_TRUE(manifest->SetField(schema::Manifest::VT_REACH_M, reach_m, 0.0));
  EXPECT_TRUE(manifest->SetField(schema::Manifest::VT_TILE_M, std::max(64.0, reach_m), 0.0));
  std::vector<std::byte> file = assemble(parts);
  const FileHeader header = *decode_header(file);
  const std::span<std::byte> info =
      std::span(file).subspan(header.directory_offset - kPageSize, kPageSize);
  std::uint64_t page_count = 0;
  std::memcpy(&page_count, info.data() + 16, sizeof page_count);
  const double cell_m = reach_m / 8.0;
  std::memcpy(info.data() + 24, &cell_m, sizeof cell_m);
  seal_page(info, page_count - 1, page_seed(header));
  return file;
}

// Squares of such a reach overflow or vanish; the search for a site must still come to its end.
TEST(MapReader, AnswersFromAMapWithAnAbsurdReach) {
  for (const double reach_m : {1e-300, 1e-9, 1e200, 1e308}) {
    const std::vector<std::byte> file = with_reach(random_map({.seed = 2}), reach_m);
    const MapReader reader = value_of(MapReader::open(file, "annealed"));
    for (const double x_m : {0.0, 3.0, 1e5, 1e307}) {
      EXPECT_TRUE(reader.observation_range({x_m, -x_m, 0.0}, 0.25)) << reach_m << " at " << x_m;
    }
  }
}

TEST(MapReader, TellsWhatIsPromisedOfTheNextDrive) {
  const CompiledMap map = random_map({.seed = 3});
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const std::span<const MapPromise> promises = reader.info().promises;
  ASSERT_EQ(promises.size(), 2u);
  EXPECT_FALSE(promises[0].is_earned);
  EXPECT_FALSE(promises[0].is_of_next_drive);
  EXPECT_EQ(promises[0].coverage, 0.0);
  EXPECT_TRUE(promises[1].is_earned);
  EXPECT_TRUE(promises[1].is_of_next_drive);
  EXPECT_EQ(promises[1].limit_m, 0.25);
  EXPECT_EQ(promises[1].coverage, 0.95);
  EXPECT_EQ(promises[1].place_count, 3u);
  EXPECT_EQ(promises[1].drive_count, 6u);
  EXPECT_EQ(promises[1].statement, map.ranges.promises[1].statement);
}

TEST(MapReader, RefusesWhatIsNoPositionOrLimit) {
  const std::vector<std::byte> file = encode_map(random_map({.seed = 3}));
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  for (const double bad : {double{NAN}, double{INFINITY}, -1.0, 0.0}) {
    EXPECT_EQ(failure_of(reader.observation_range({0.0, 0.0, 0.0}, bad)).code,
              ErrorCode::kBadArgument);
  }
  EXPECT_FALSE(reader.observation_range({0.0, NAN, 0.0}, 0.1));
}

TEST(MapReader, RefusesAFileThatNamesNoLookUp) {
  const std::vector<std::byte> file =
      with_header(encode_map(random_map({.seed = 4})),
                  [](FileHeader& header) { header.compatible_features = 0; });
  EXPECT_EQ(failure_of(MapReader::open(file, "annealed")).code, ErrorCode::kBadLayer);
}

TEST(MapReader, ChecksAPageOnlyWhenItIsUsed) {
  CompiledMap map = random_map({.seed = 4, .site_count = 160, .nd_count = 0, .run_count = 1});
  for (std::size_t i = 0; i < 160; ++i) {
    map.sites.sites[i].p_map_m = {10.0 * static_cast<double>(i), 10.0, 0.0};
  }
  std::vector<std::byte> file = encode_map(map);
  // The last page but one: rows ascend with x.
  file[decode_header(file)->directory_offset - 2 * kPageSize] ^= std::byte{1};
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  EXPECT_TRUE(reader.observation_range(world(map, {10.0, 10.0, 0.0}), 0.1));
  for (int i = 0; i < 2; ++i) {  // and it stays refused
    const Error error = failure_of(reader.observation_range(world(map, {1590.0, 10.0, 0.0}), 0.1));
    EXPECT_EQ(error.code, ErrorCode::kChecksumMismatch);
    EXPECT_EQ(error.place.rfind("section look-up, byte ", 0), 0u) << error.place;
  }
}

// Every slot names a cell far away, as only the owner of the map can make them, and the last page
// of slots is left unsealed. A search that begins in the first page ends before: there are more
// slots than cells can be.
TEST(MapReader, VisitsNoMoreSlotsThanThereAreRows) {
  constexpr std::size_t kSites = 400;
  constexpr std::uint64_t kSlots = 2 * kSites;
  CompiledMap map = random_map({.seed = 4, .site_count = kSites, .nd_count = 0, .run_count = 1});
  std::optional<std::size_t> sought;
  for (std::size_t i = 0; i < kSites; ++i) {
    map.sites.sites[i].p_map_m = {20.0 * static_cast<double>(i), 8.0, 0.0};
    const auto cell = static_cast<std::int32_t>(20 * i / 16);
    if (first_slot(cell, 0, kSlots) < kSlotsPerPage) sought = i;
  }
  ASSERT_TRUE(sought);
  std::vector<std::byte> file = encode_map(map);
  const FileHeader header = *decode_header(file);
  const std::uint64_t rows = LookUpRowLayout({2, 2, 2}).rows_per_page;
  const std::uint64_t row_pages = (kSites + rows - 1) / rows;
  const std::span<std::byte> slots = std::span(file).subspan(
      header.directory_offset - (1 + row_pages + 4) * kPageSize, 4 * kPageSize);
  for (std::uint64_t i = 0; i < kSlots; ++i) {
    const LookUpSlot other{1 << 20, static_cast<std::int32_t>(i), 0, 1};
    std::memcpy(&slots[i / kSlotsPerPage * kPageSize + i % kSlotsPerPage * sizeof other], &other,
                sizeof other);
  }
  for (std::uint64_t page = 0; page < 3; ++page) {
    seal_page(slots.subspan(page * kPageSize, kPageSize), page, page_seed(header));
  }
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const Error error =
      failure_of(reader.observation_range(world(map, map.sites.sites[*sought].p_map_m), 0.1));
  EXPECT_EQ(error.code, ErrorCode::kBadLayer) << to_string(error);
}

TEST(MapReader, RefusesAPageOfAnotherVersionOfTheMap) {
  CompiledMap map = random_map({.seed = 4});
  std::vector<std::byte> file = encode_map(map);
  map.release += 1;
  const std::vector<std::byte> newer = encode_map(map);
  ASSERT_EQ(file.size(), newer.size());
  // Slots and rows of the newer version, each page whole in itself, behind the header of the older.
  const std::uint64_t end = decode_header(file)->directory_offset - kPageSize;
  const std::uint64_t begin = end - 2 * kPageSize;
  std::copy(newer.begin() + static_cast<std::ptrdiff_t>(begin),
            newer.begin() + static_cast<std::ptrdiff_t>(end),
            file.begin() + static_cast<std::ptrdiff_t>(begin));
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  EXPECT_EQ(failure_of(reader.observation_range(world(map, map.sites.sites[0].p_map_m), 0.1)).code,
            ErrorCode::kChecksumMismatch);
}

TEST(MapReader, NeverAnswersWronglyFromADamagedFile) {
  const CompiledMap map = random_map({.seed = 5, .site_count = 6, .nd_count = 4, .model_size = 50});
  const std::vector<std::byte> file = encode_map(map);
  for (std::size_t i = 0; i < file.size(); ++i) {
    std::vector<std::byte> damaged = file;
    damaged[i] ^= std::byte(1 << (i % 8));
    const Result<MapReader> reader = MapReader::open(damaged, "annealed");
    if (!reader) continue;
    for (const Site& site : map.sites.sites) {
      const Position position = world(map, site.p_map_m);
      const Result<RangeAnswer> answer = reader->observation_range(position, 0.25);
      if (answer) expect_equal(*answer, brute_force(map, position, 0.25));
    }
    ASSERT_FALSE(testing::Test::HasFailure()) << "after a flip in byte " << i;
  }
  for (std::size_t size = 0; size < file.size(); ++size) {
    ASSERT_FALSE(MapReader::open(std::span(file).first(size), "annealed"))
        << "cut at byte " << size;
  }
}

TEST(MapReader, AnswersSeveralThreadsAtOnce) {
  const CompiledMap map = random_map({.seed = 6, .site_count = 300, .tile_m = 16.0});
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < wrong.size(); ++thread) {
    threads.emplace_back([&, thread] {
      for (const Site& site : map.sites.sites) {
        const Position position = world(map, site.p_map_m);
        const Result<RangeAnswer> answer = reader.observation_range(position, 0.25);
        if (!answer || answer->site != brute_force(map, position, 0.25).site) ++wrong[thread];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(MapReader, AllocatesNothingToLookUp) {
  const CompiledMap map = random_map({.seed = 7});
  const std::vector<std::byte> file = encode_map(map);
  for (const char* callers : {"annealed", "pcl-ndt"}) {
    const MapReader reader = value_of(MapReader::open(file, callers));
    double sum_m = 0.0;
    const std::size_t before = allocation_count();
    for (const Site& site : map.sites.sites) {
      sum_m += reader.observation_range(world(map, site.p_map_m), 0.25)->range_m;
      sum_m += reader.look(world(map, site.p_map_m), 0.25, 90.0)->look.range_m;
      sum_m += reader.look_plan(world(map, site.p_map_m), 0.31, true)->second.range_m;
    }
    EXPECT_EQ(allocation_count(), before) << callers;
    EXPECT_GT(sum_m, 0.0);
  }
}

TEST(MapReader, KnowsNothingForALocalizerWhoseErrorsWereNotMeasured) {
  const CompiledMap map = random_map({.seed = 7});
  const std::vector<std::byte> file = encode_map(map);
  const Position position = world(map, map.sites.sites[3].p_map_m);
  for (const char* callers : {"pcl-ndt", "", "anneal", "annealed/2", "annealed/", "/3"}) {
    const MapReader reader = value_of(MapReader::open(file, callers));
    EXPECT_FALSE(reader.info().is_for_caller) << callers;
    for (const double limit_m : {0.01, 0.1, 0.25}) {
      const RangeAnswer answer = value_of(reader.observation_range(position, limit_m));
      EXPECT_TRUE(std::isnan(answer.probability)) << callers;
      EXPECT_TRUE(std::isnan(answer.mean_error_m)) << callers;
      EXPECT_EQ(answer.range_m, map.ranges.looks.back().range_m) << "as far as the map goes";
      EXPECT_EQ(answer.flags, limit_m < 0.1 ? kAnswerUnknownLocalizer | kAnswerTighterLimit
                                            : kAnswerUnknownLocalizer);
      EXPECT_EQ(answer.site, 3u);
      EXPECT_NEAR(answer.distance_m, 0.0, 1e-9);
    }
    const RangeAnswer far = value_of(reader.observation_range({1e6, 1e6, 0.0}, 0.25));
    EXPECT_TRUE(std::isnan(far.probability));
    EXPECT_EQ(far.flags, kAnswerUnknownLocalizer | kAnswerFar);
  }
}

TEST(MapReader, NamesTheLocalizerWhoseErrorsWereMeasured) {
  CompiledMap map = random_map({.seed = 7});
  map.model.localizer = {"my-ndt", 4, {{"leaf_m", "0.5"}, {"resolution_m", "2"}}};
  const std::vector<std::byte> file = encode_map(map);
  for (const char* callers : {"my-ndt", "my-ndt/4"}) {
    MapReader opened = value_of(MapReader::open(file, callers));
    const MapReader reader = std::move(opened);  // its texts come along
    EXPECT_EQ(reader.info().localizer, "my-ndt");
    EXPECT_EQ(reader.info().localizer_version, 4u);
    EXPECT_EQ(reader.info().localizer_parameters, "leaf_m=0.5, resolution_m=2");
    EXPECT_TRUE(reader.info().is_for_caller);
    const RangeAnswer answer =
        value_of(reader.observation_range(world(map, map.sites.sites[3].p_map_m), 0.25));
    EXPECT_EQ(answer.flags & kAnswerUnknownLocalizer, 0u);
    EXPECT_GE(answer.probability, 0.0);
  }
}

// A file in memory that is sealed against writing stands for a read-only file system.
TEST(MapReader, ReadsFromStorageThatCannotBeWritten) {
  const CompiledMap map = random_map({.seed = 9});
  const std::vector<std::byte> file = encode_map(map);
  const int descriptor = ::memfd_create("map", MFD_ALLOW_SEALING | MFD_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  ASSERT_EQ(::write(descriptor, file.data(), file.size()), static_cast<ssize_t>(file.size()));
  ASSERT_EQ(::fcntl(descriptor, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK), 0);
  const MapReader reader =
      value_of(MapReader::open("/proc/self/fd/" + std::to_string(descriptor), "annealed"));
  EXPECT_EQ(reader.observation_range(world(map, map.sites.sites[7].p_map_m), 0.1)->site, 7u);
  ::close(descriptor);
}

// A file that is shortened in place under a reader would end the process (SIGBUS).
TEST(MapReader, InMemoryOutlivesItsFile) {
  const CompiledMap map = random_map({.seed = 9});
  const std::vector<std::byte> file = encode_map(map);
  const int descriptor = ::memfd_create("map", MFD_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  ASSERT_EQ(::write(descriptor, file.data(), file.size()), static_cast<ssize_t>(file.size()));
  const std::string path = "/proc/self/fd/" + std::to_string(descriptor);
  const MapReader reader = value_of(MapReader::open_in_memory(path, "annealed"));
  ASSERT_EQ(::ftruncate(descriptor, 0), 0);
  EXPECT_EQ(reader.observation_range(world(map, map.sites.sites[7].p_map_m), 0.1)->site, 7u);
  EXPECT_EQ(value_of(reader.sites(0)).size(), map.sites.sites.size());
  ::close(descriptor);
  EXPECT_EQ(failure_of(MapReader::open_in_memory("/nowhere.slmap", "annealed")).code,
            ErrorCode::kFileNotFound);
}

TEST(MapReader, OutlivesBeingMoved) {
  const CompiledMap map = random_map({.seed = 8});
  const std::vector<std::byte> file = encode_map(map);
  MapReader opened = value_of(MapReader::open(file, "annealed"));
  const MapReader reader = std::move(opened);
  EXPECT_EQ(reader.info().ranges_m.back(), 50.0);
  EXPECT_EQ(reader.info().map_id, map.map_id);
  EXPECT_TRUE(reader.observation_range(world(map, {0.0, 0.0, 0.0}), 0.1));
}

TEST(MapReader, TellsItsWorldAndWhereExportedCloudsLie) {
  CompiledMap map = random_map({.seed = 2});
  map.world = "utm:32N";
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  EXPECT_EQ(reader.info().world, "utm:32N");
  // Its frame begins at (448000, -192, 0).
  EXPECT_EQ(reader.info().export_origin_world_m, (std::array<double, 3>{400'000.0, 0.0, 0.0}));
  map.world = "local";
  const std::vector<std::byte> local = encode_map(map);
  EXPECT_EQ(MapReader::open(local, "annealed")->info().world, "local");
  EXPECT_EQ(export_origin_world_m({-64.0, 99'968.0, 300'000.0}), (std::array<double, 3>{}));
  EXPECT_EQ(export_origin_world_m({-100'032.0, 5'429'500.0, 0.0}),
            (std::array<double, 3>{-200'000.0, 5'400'000.0, 0.0}));
}

TEST(MapReaderColumns, AreThoseOfTheMapByTheNumberOfASite) {
  const CompiledMap map = random_map({.seed = 4, .site_count = 130, .has_columns = true});
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  ASSERT_EQ(reader.info().columns.size(), 2U);
  EXPECT_EQ(reader.info().columns[0], "clearance_m");
  EXPECT_EQ(reader.info().columns[1], "kind");
  const MapColumn column = value_of(reader.column("clearance_m"));
  EXPECT_EQ(column.unit, "m");
  EXPECT_TRUE(std::ranges::equal(column.values, map.columns[0].values));
  EXPECT_TRUE(std::ranges::equal(value_of(reader.column("kind")).values, map.columns[1].values));
  EXPECT_EQ(reader.column("height_m").error().code, ErrorCode::kBadArgument);
}

TEST(MapReaderPoses, AreConstrainedUnlessTheColumnNamesADirection) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  const std::vector<std::byte> silent = encode_map(map);
  const MapPoses known = value_of(value_of(MapReader::open(silent, "annealed")).poses());
  EXPECT_TRUE(known.is_constrained(7));
  EXPECT_EQ(known.sigma_m(7), 0.0);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  map.columns = {{"pose_sigma_m", "m", std::vector<float>(130, -kInfinity)},
                 {"unconstrained", "", std::vector<float>(130, 0.0F)}};
  map.columns[0].values[7] = 2.5F;
  map.columns[0].values[8] = kInfinity;
  for (const std::size_t site : {7U, 8U, 9U}) map.columns[1].values[site] = 1.0F;
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const MapPoses poses = value_of(reader.poses());
  EXPECT_TRUE(poses.is_constrained(6));
  EXPECT_EQ(poses.sigma_m(6), 0.0);
  EXPECT_FALSE(poses.is_constrained(7));
  EXPECT_EQ(poses.sigma_m(7), 2.5);
  EXPECT_TRUE(std::isinf(poses.sigma_m(8)));
  EXPECT_FALSE(poses.is_constrained(9));
  EXPECT_EQ(poses.sigma_m(9), 0.0);
}

TEST(MapReaderErrors, AreTheColumnsOfTrackingAndInfiniteWithoutThem) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  const std::vector<std::byte> without = encode_map(map);
  const MapErrors none = value_of(value_of(MapReader::open(without, "annealed")).errors());
  EXPECT_TRUE(std::isinf(none.of_range(7).longitudinal_m));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < kTrackingRangeColumns.size(); ++i) {
    const auto number = static_cast<float>(i + 1);
    SiteColumn column{std::string(kTrackingRangeColumns[i]),
                      "",
                      std::vector<float>(130, kInfinity),
                      {0.1F * number, number, kInfinity}};
    column.values[7] = 0.1F * number;
    map.columns.push_back(column);
    column.name = kTrackingSampleColumns[i];
    column.values[7] = number;
    map.columns.push_back(column);
  }
  std::ranges::sort(map.columns, {}, &SiteColumn::name);
  const std::vector<std::byte> file = encode_map(map);
  const MapErrors errors = value_of(value_of(MapReader::open(file, "annealed")).errors());
  const PoseErrors of_range = errors.of_range(7);
  EXPECT_EQ(of_range.longitudinal_m, double{0.1F});
  EXPECT_EQ(of_range.lateral_m, double{0.1F * 2.0F});
  EXPECT_EQ(of_range.yaw_rad, double{0.1F * 3.0F});
  EXPECT_EQ(of_range.kept_longitudinal, double{0.1F * 4.0F});
  EXPECT_EQ(errors.of_sample(7).lateral_m, 2.0);
  EXPECT_TRUE(std::isinf(errors.of_range(8).yaw_rad)) << "not measured there";
  EXPECT_TRUE(std::isinf(errors.of_range(130).yaw_rad)) << "no such site";
}

// Every site: the second look at the first limit, and the first at the others, where it is not good
// enough.
void add_tracking_looks(CompiledMap& map) {
  const std::size_t site_count = map.sites.sites.size();
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    map.columns.push_back({tracking_look_column(0, limit),
                           "",
                           std::vector<float>(site_count, limit == 0 ? 1.0F : -1.0F),
                           {-1.0F, 1.0F}});
    map.columns.push_back(
        {tracking_look_column(1, limit), "", std::vector<float>(site_count, 0.25F), {0.25F, 0.5F}});
  }
  std::ranges::sort(map.columns, {}, &SiteColumn::name);
}

TEST(MapReaderTracking, IsAnsweredByItsOwnLookWhereNoPlanApplies) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  ASSERT_TRUE(map.looks && map.looks->ranges.looks.size() >= 2);
  ASSERT_GE(map.ranges.promises.size(), 2u);
  map.looks->ranges.plan.reset();
  add_tracking_looks(map);
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const Position place = world(map, map.sites.sites[7].p_map_m);
  const double tight_m = map.ranges.promises[0].limit_m;
  const LookPlanAnswer tracking = value_of(reader.look_plan(place, tight_m, true));
  EXPECT_TRUE(is_same(tracking.first.look, reader.info().looks[1]));
  EXPECT_EQ(tracking.first.flags & kAnswerUnmet, 0u);
  EXPECT_EQ(tracking.first.probability, 0.25);
  EXPECT_TRUE(std::isnan(tracking.first.mean_error_m));
  const double loose_m = map.ranges.promises[1].limit_m;
  const LookPlanAnswer unmet = value_of(reader.look_plan(place, loose_m, true));
  EXPECT_TRUE(is_same(unmet.first.look, reader.info().looks[0]));
  EXPECT_NE(unmet.first.flags & kAnswerUnmet, 0u);
  const LookPlanAnswer searching = value_of(reader.look_plan(place, tight_m, false));
  const LookAnswer look = value_of(reader.look(place, tight_m));
  EXPECT_TRUE(is_same(searching.first.look, look.look));
  EXPECT_EQ(searching.first.probability, look.probability);
  const LookPlanAnswer hazy = value_of(reader.look_plan(place, tight_m, true, 1.0));
  EXPECT_NE(hazy.first.flags & kAnswerNotVisible, 0u) << "the look reaches farther than 1 m";
  const std::array<double, 3> far = world(map, {1e5, 0.0, 0.0});
  EXPECT_NE(value_of(reader.look_plan(far, tight_m, true)).first.flags & kAnswerFar, 0u);
}

TEST(MapReaderTracking, GivesAPlanItsFlagAndLeavesItsLooks) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  const std::vector<Look>& looks = map.looks->ranges.looks;
  LookPlan own;
  own.limit_m = map.ranges.promises[0].limit_m;
  own.first = looks.front();
  own.second = looks.back();
  map.looks->ranges.plan = own;
  const std::vector<std::byte> without = encode_map(map);
  add_tracking_looks(map);
  const std::vector<std::byte> file = encode_map(map);
  const Position place = world(map, map.sites.sites[7].p_map_m);
  const double loose_m = map.ranges.promises[1].limit_m;
  const MapReader before = value_of(MapReader::open(without, "annealed"));
  const MapReader after = value_of(MapReader::open(file, "annealed"));
  const LookPlanAnswer plan = value_of(after.look_plan(place, loose_m, true));
  ASSERT_TRUE(plan.has_second);
  EXPECT_TRUE(
      is_same(plan.first.look, value_of(before.look_plan(place, loose_m, true)).first.look));
  EXPECT_NE(plan.first.flags & kAnswerUnmet, 0u);
}

TEST(MapReaderTracking, IsRefusedWhereItsColumnsAreDamaged) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  map.looks->ranges.plan.reset();
  add_tracking_looks(map);
  std::vector<std::byte> file = encode_map(map);
  const auto column = std::ranges::find(map.columns, "tracking_look_0", &SiteColumn::name);
  const std::vector<std::byte> values = encode_column(*column);
  const auto found = std::search(file.begin(), file.end(), values.begin(), values.end());
  ASSERT_NE(found, file.end());
  *found ^= std::byte{1};
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const Position place = world(map, map.sites.sites[7].p_map_m);
  const double limit_m = map.ranges.promises[0].limit_m;
  EXPECT_TRUE(reader.look_plan(place, limit_m, false).has_value());
  EXPECT_EQ(reader.look_plan(place, limit_m, true).error().code, ErrorCode::kChecksumMismatch);
}

TEST(MapReaderColumns, AreRefusedWhereTheyAreDamaged) {
  const CompiledMap map = random_map({.seed = 4, .site_count = 130, .has_columns = true});
  std::vector<std::byte> file = encode_map(map);
  const std::vector<std::byte> values = encode_column(map.columns[1]);
  const auto found = std::search(file.begin(), file.end(), values.begin(), values.end());
  ASSERT_NE(found, file.end());
  *found ^= std::byte{1};
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  EXPECT_TRUE(reader.column("clearance_m"));
  EXPECT_EQ(reader.column("kind").error().code, ErrorCode::kChecksumMismatch);
}

TEST(MapProtection, IsThatOfTheKindOfPlaceUnlessTheSitesOwnErrorIsLarger) {
  CompiledMap map = random_map({.seed = 4, .site_count = 130});
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  SiteColumn kinds{"place_kind", "", std::vector<float>(130, 1.0F), {}};
  kinds.values[9] = 77.0F;  // of a later program
  map.columns.push_back(kinds);
  for (const std::string_view name : kTrackingRangeColumns) {
    map.columns.push_back(
        {std::string(name), "", std::vector<float>(130, kInfinity), {0.5F, kInfinity}});
  }
  map.columns.back().values[7] = 0.5F;
  map.columns[map.columns.size() - 2].values[7] = 0.5F;  // yaw
  std::ranges::sort(map.columns, {}, &SiteColumn::name);
  const std::vector<std::byte> file = encode_map(map);
  const MapReader reader = value_of(MapReader::open(file, "annealed"));
  const MapProtection protection = value_of(protection_of(reader));
  const ProtectionRow& row = protection_row(PlaceGroup::kStreet);
  EXPECT_EQ(protection.at(6).levels, row.percent_errors);
  EXPECT_EQ(protection.at(6).place_kind, 1u);
  EXPECT_EQ(protection.at(7).levels[0], row.percent_errors[0]);
  EXPECT_EQ(protection.at(7).levels[3], row.percent_factors[3] * 0.5);
  const ProtectionRow& any = protection_row(PlaceGroup::kAny);
  EXPECT_EQ(protection.at(9).levels, any.percent_errors);
  EXPECT_EQ(protection.at(130).levels, any.percent_errors) << "no such site";
  EXPECT_EQ(protection.at(6, 0.001).levels[1], kUnavailable) << "a risk without blocks";
  EXPECT_TRUE(std::isfinite(protection.at(6).levels[1]));
}

}  // namespace
}  // namespace sightline
