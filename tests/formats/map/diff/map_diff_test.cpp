#include "formats/map/diff/diff_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::Contains;
using testing::Field;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

MapDiff diff_of(const CompiledMap& before, const CompiledMap& after) {
  const Result<MapDiff> diff = diff_maps(encode_map(before), encode_map(after), MapDiffOptions());
  EXPECT_TRUE(diff) << to_string(diff.error());
  return diff ? *diff : MapDiff();
}

// What the diff says, worked out from two whole maps without tiles or digests.
struct PlainDiff {
  std::multiset<std::tuple<int, double, double, double>> nds;  // change and mean, rounded to 1 mm
  std::map<std::uint32_t, double> changed;                     // site -> distance to the old one
  std::set<std::uint32_t> added;
  std::set<std::uint32_t> removed;
  std::vector<std::array<std::uint32_t, 4>> limits;  // rose, fell, newly unmet, no longer unmet
};

std::tuple<int, double, double, double> nd_key(NdChange change, const Eigen::Vector3d& mean_m) {
  const auto rounded = [](double value) { return std::round(1e3 * value); };
  return {static_cast<int>(change), rounded(mean_m.x()), rounded(mean_m.y()), rounded(mean_m.z())};
}

std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, Nd> nds_in_world(const NdtMap& ndt) {
  std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, Nd> nds;
  for (const Nd& nd : ndt.nds) {
    const Eigen::Vector3d cells = ndt.frame.origin_world_m / ndt.cell_m;
    Nd& in_world = nds[{nd.key.x + std::llround(cells.x()), nd.key.y + std::llround(cells.y()),
                        nd.key.z + std::llround(cells.z())}];
    in_world = nd;
    in_world.mean_m += ndt.frame.origin_world_m;
  }
  return nds;
}

std::optional<std::size_t> nearest(const CompiledMap& map, const Eigen::Vector3d& p_world_m) {
  std::optional<std::size_t> best;
  double best_m = map.reach_m;
  for (std::size_t i = 0; i < map.sites.sites.size(); ++i) {
    const Eigen::Vector3d p_m = p_world_m - map.ndt.frame.origin_world_m;
    const Eigen::Vector3d off_m = map.sites.sites[i].p_map_m - p_m;
    if (std::abs(off_m.z()) >= 1.0) continue;  // on another level
    const double distance_m = off_m.norm();
    if (distance_m < best_m || (!best && distance_m == best_m)) {
      best = i;
      best_m = distance_m;
    }
  }
  return best;
}

// Farther than the tolerance, and than one sigma in the direction of the move.
bool is_elsewhere(const Nd& before, const Nd& after) {
  const double tolerance_m = MapDiffOptions().tolerance_m;
  const Eigen::Vector3d d_m = after.mean_m - before.mean_m;
  double sigmas2 = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double along_m = d_m.dot(before.eigenvectors.col(axis));
    const double sigma_m = std::max(std::sqrt(before.eigenvalues_m2[axis]), tolerance_m);
    sigmas2 += along_m * along_m / (sigma_m * sigma_m);
  }
  return d_m.norm() > tolerance_m && sigmas2 > 1.0;
}

void compare_nds(const CompiledMap& before, const CompiledMap& after, PlainDiff& plain) {
  const auto old_nds = nds_in_world(before.ndt);
  const auto new_nds = nds_in_world(after.ndt);
  for (const auto& [cell, nd] : old_nds) {
    if (!new_nds.contains(cell)) plain.nds.insert(nd_key(NdChange::kRemoved, nd.mean_m));
  }
  for (const auto& [cell, nd] : new_nds) {
    const auto old_nd = old_nds.find(cell);
    if (old_nd == old_nds.end()) {
      plain.nds.insert(nd_key(NdChange::kAdded, nd.mean_m));
    } else if (is_elsewhere(old_nd->second, nd)) {
      plain.nds.insert(nd_key(NdChange::kMoved, nd.mean_m));
    }
  }
}

PlainDiff plain_diff(const CompiledMap& before, const CompiledMap& after) {
  PlainDiff plain;
  compare_nds(before, after, plain);
  const std::size_t limits = after.ranges.promises.size();
  plain.limits.resize(limits);
  for (std::uint32_t site = 0; site < after.sites.sites.size(); ++site) {
    const Eigen::Vector3d p_m = after.sites.sites[site].p_map_m + after.ndt.frame.origin_world_m;
    const std::optional<std::size_t> was = nearest(before, p_m);
    if (!was) {
      plain.added.insert(site);
      continue;
    }
    for (std::size_t limit = 0; limit < limits; ++limit) {
      const double old_m = before.ranges.range_m(*was, limit);
      const double new_m = after.ranges.range_m(site, limit);
      const int old_flags = before.ranges.flags[*was * limits + limit];
      const int new_flags = after.ranges.flags[site * limits + limit];
      plain.limits[limit][0] += new_m > old_m ? 1 : 0;
      plain.limits[limit][1] += new_m < old_m ? 1 : 0;
      plain.limits[limit][2] += (new_flags & kUnmet) > (old_flags & kUnmet) ? 1 : 0;
      plain.limits[limit][3] += (new_flags & kUnmet) < (old_flags & kUnmet) ? 1 : 0;
      if (new_m == old_m && new_flags == old_flags) continue;
      plain.changed[site] =
          (before.sites.sites[*was].p_map_m + before.ndt.frame.origin_world_m - p_m).norm();
    }
  }
  for (std::uint32_t site = 0; site < before.sites.sites.size(); ++site) {
    if (!nearest(after, before.sites.sites[site].p_map_m + before.ndt.frame.origin_world_m)) {
      plain.removed.insert(site);
    }
  }
  return plain;
}

void expect_equal(const MapDiff& diff, const PlainDiff& plain) {
  std::multiset<std::tuple<int, double, double, double>> nds;
  for (const NdDiff& nd : diff.nds) nds.insert(nd_key(nd.change, nd.mean_world_m));
  EXPECT_EQ(nds, plain.nds);
  std::map<std::uint32_t, double> changed;
  std::set<std::uint32_t> added;
  std::set<std::uint32_t> removed;
  for (const SiteDiff& site : diff.sites) {
    if (site.change == SiteChange::kChanged) changed[site.site] = site.distance_m;
    if (site.change == SiteChange::kAdded) added.insert(site.site);
    if (site.change == SiteChange::kRemoved) removed.insert(site.site);
  }
  EXPECT_EQ(added, plain.added);
  EXPECT_EQ(removed, plain.removed);
  ASSERT_EQ(changed.size(), plain.changed.size());
  for (const auto& [site, distance_m] : plain.changed) {
    ASSERT_TRUE(changed.contains(site)) << site;
    EXPECT_NEAR(changed[site], distance_m, 1e-6) << site;
  }
  ASSERT_EQ(diff.limits.size(), plain.limits.size());
  for (std::size_t i = 0; i < diff.limits.size(); ++i) {
    const LimitDiff& limit = diff.limits[i];
    EXPECT_THAT((std::array{limit.rose, limit.fell, limit.newly_unmet, limit.no_longer_unmet}),
                testing::Eq(plain.limits[i]));
  }
}

TEST(MapDiff, OfAMapAndItselfIsEmpty) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const CompiledMap map = random_map({.seed = seed});
    const MapDiff diff = diff_of(map, map);
    EXPECT_TRUE(diff.is_same());
    EXPECT_TRUE(diff.facts.empty() && diff.nds.empty() && diff.sites.empty());
    EXPECT_TRUE(diff.stretches.empty());
    EXPECT_EQ(diff.tiles_added + diff.tiles_removed + diff.tiles_changed, 0u);
  }
}

TEST(MapDiff, AgreesWithBruteForceOnRandomMaps) {
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE(seed);
    const CompiledMap map = random_map({.seed = seed, .site_count = 60, .nd_count = 90});
    // As a reader sees them: the writer rounds NDs.
    const Result<CompiledMap> before = read_map(encode_map(map));
    const Result<CompiledMap> after =
        read_map(encode_map(changed_map(map, seed + 1000, seed % 2 == 0)));
    ASSERT_TRUE(before && after);
    const MapDiff diff = diff_of(*before, *after);
    EXPECT_FALSE(diff.is_same());
    EXPECT_TRUE(diff.has_comparable_nds);
    expect_equal(diff, plain_diff(*before, *after));
  }
}

TEST(MapDiff, PutsEveryChangeIntoOneStretch) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const CompiledMap map = random_map({.seed = seed, .site_count = 200, .extent_m = 300.0});
    const MapDiff diff = diff_of(map, changed_map(map, seed));
    std::uint64_t nds = diff.nds_off_route + diff.nds_scattered;
    std::uint32_t rose = 0;
    std::uint32_t added = 0;
    std::uint32_t removed = 0;
    for (const Stretch& stretch : diff.stretches) {
      nds += stretch.nds_added + stretch.nds_removed + stretch.nds_moved;
      rose += stretch.limits[0].rose;
      added += stretch.sites_added;
      removed += stretch.sites_removed;
      EXPECT_LE(stretch.begin_s_m, stretch.end_s_m);
    }
    EXPECT_EQ(nds, diff.nds.size());
    EXPECT_EQ(rose, diff.limits[0].rose);
    EXPECT_EQ(added, diff.sites_added);
    EXPECT_EQ(removed, diff.sites_removed);
  }
}

CompiledMap without(CompiledMap map, const std::function<bool(const Nd&)>& is_gone) {
  std::erase_if(map.ndt.nds, is_gone);
  return map;
}

TEST(MapDiff, CallsAStreetChangedWhereManyOfItsNdsAreAndLeavesTheRestScattered) {
  const CompiledMap map =
      random_map({.seed = 9, .site_count = 200, .nd_count = 30000, .extent_m = 300.0});
  const Eigen::Vector3d p_m = map.sites.sites[100].p_map_m;
  const MapDiff razed =
      diff_of(map, without(map, [&](const Nd& nd) { return (nd.mean_m - p_m).norm() < 60.0; }));
  ASSERT_THAT(razed.stretches, Not(IsEmpty()));
  for (const Stretch& stretch : razed.stretches) EXPECT_TRUE(stretch.has_changed_place);
  int number = 0;
  const MapDiff worn = diff_of(map, without(map, [&](const Nd&) { return number++ % 50 == 0; }));
  EXPECT_EQ(worn.nds.size(), 600u);
  EXPECT_THAT(worn.stretches, IsEmpty());
  EXPECT_EQ(worn.nds_scattered + worn.nds_off_route, 600u);
}

CompiledMap with_a_wall(CompiledMap map, const Eigen::Vector3d& moved_m) {
  Nd& nd = map.ndt.nds[0];
  const double cell_m = map.ndt.cell_m;
  nd.mean_m = cell_m * (Eigen::Vector3d(nd.key.x, nd.key.y, nd.key.z).array() + 0.5).matrix();
  nd.mean_m += moved_m;
  nd.covariance_m2 = Eigen::Vector3d(0.25, 0.09, 0.0004).asDiagonal();
  nd.eigenvalues_m2 = nd.covariance_m2.diagonal();
  nd.eigenvectors = Eigen::Matrix3d::Identity();
  return map;
}

TEST(MapDiff, CallsAnNdMovedOutOfItsWallButNotAlongIt) {
  const CompiledMap map = random_map({.seed = 4});
  const CompiledMap before = with_a_wall(map, Eigen::Vector3d::Zero());
  const auto moved_by = [&](const Eigen::Vector3d& by_m) {
    return diff_of(before, with_a_wall(map, by_m)).nds_moved;
  };
  EXPECT_EQ(moved_by({0.3, 0.0, 0.0}), 0u);
  EXPECT_EQ(moved_by({0.0, 0.2, 0.0}), 0u);
  EXPECT_EQ(moved_by({0.0, 0.0, 0.3}), 1u);
  EXPECT_EQ(moved_by({0.0, 0.0, 0.09}), 0u) << "within the tolerance";
}

TEST(MapDiff, ReadsNoTileThatStayed) {
  const CompiledMap map = random_map(
      {.seed = 5, .site_count = 400, .nd_count = 800, .extent_m = 400.0, .model_size = 100});
  CompiledMap changed = map;
  const std::vector<std::byte> before = encode_map(map);
  changed.ranges.flags[0] ^= kExtrapolated;
  const std::vector<std::byte> after = encode_map(changed);
  const Result<MapDiff> same = diff_maps(before, before, MapDiffOptions());
  const Result<MapDiff> other = diff_maps(before, after, MapDiffOptions());
  ASSERT_TRUE(same && other);
  EXPECT_EQ(other->tiles_changed, 1u);
  EXPECT_THAT(other->sites, SizeIs(1));
  EXPECT_LT(other->bytes_read - same->bytes_read, (before.size() + after.size()) / 20);
}

TEST(MapDiff, NamesWhatChangedInTheMapAsAWhole) {
  const CompiledMap map = random_map({.seed = 3});
  CompiledMap changed = map;
  changed.version = "2026.2";
  changed.definitions[0].version += 1;
  changed.definitions.push_back({"weather", 1});
  changed.model.bytes[0] ^= std::byte{1};
  changed.model.digest = sha256(changed.model.bytes);
  const MapDiff diff = diff_of(map, changed);
  EXPECT_FALSE(diff.is_same());
  const auto named = [](const char* name) { return Contains(Field(&FactDiff::name, name)); };
  EXPECT_THAT(diff.facts, SizeIs(4));
  EXPECT_THAT(diff.facts, named("version"));
  EXPECT_THAT(diff.facts, named("definitions.ndt-map"));
  EXPECT_THAT(diff.facts, named("definitions.weather"));
  EXPECT_THAT(diff.facts, named("model.digest"));
}

TEST(MapDiff, NamesEveryFigureOfTheManifest) {
  const CompiledMap map = random_map({.seed = 3});
  const auto changes_of = [&](const auto& change) {
    CompiledMap changed = map;
    change(changed);
    std::vector<std::string> names;
    for (const FactDiff& fact : diff_of(map, changed).facts) names.push_back(fact.name);
    return names;
  };
  using testing::ElementsAre;
  EXPECT_THAT(changes_of([](CompiledMap& changed) { changed.measurement.coarse_cells += 1; }),
              ElementsAre("measurement.coarse_cells"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) { changed.measurement.leaf_m = 2.0; }),
              ElementsAre("measurement.leaf_m"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) { changed.measurement.offsets[1].x_m = 0.0; }),
              ElementsAre("measurement.offsets.1.x_m"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) { changed.predicted.support_margin = 0.5; }),
              ElementsAre("support_margin"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) {
                changed.sharpness->of_given->mean_plane_variance_m2 = 0.004;
              }),
              ElementsAre("sharpness.of_given.mean_plane_variance_m2"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) { changed.sharpness->of_map.plane_points = 1; }),
              ElementsAre("sharpness.plane_points"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) {
                changed.trajectory->pieces.front().way_m = 80.0;
                changed.trajectory->pieces.push_back({90, 2'000'000'000, 10, 9.5, {}});
              }),
              ElementsAre("trajectory.pieces.0.way_m", "trajectory.pieces.1.first_scan",
                          "trajectory.pieces.1.stamp_ns", "trajectory.pieces.1.scan_count",
                          "trajectory.pieces.1.way_m", "trajectory.pieces.1.begin_map_m"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) {
                changed.trajectory->unconstrained = {
                    {3, 9, 27.0, {true, false, false, Substitute::kConstantSpeed}, 1.4}};
              }),
              ElementsAre("trajectory.unconstrained"));
  EXPECT_THAT(changes_of([](CompiledMap& changed) {
                changed.notices = {{"given-poses-disagree", "they disagree", 2, 3, 4, 69.1, "m"}};
              }),
              ElementsAre("notice.given-poses-disagree"));
}

TEST(MapDiff, SaysWhatBecameOfColumnsOfSites) {
  const CompiledMap before = random_map({.seed = 3, .has_columns = true});
  CompiledMap after = before;
  std::vector<float>& clearance_m = after.columns[0].values;
  const auto finite =
      std::ranges::find_if(clearance_m, [](float value) { return std::isfinite(value); });
  *finite += 2.5F;
  after.columns[1].name = "sort";
  const MapDiff diff = diff_of(before, after);
  ASSERT_THAT(diff.facts, SizeIs(3));
  EXPECT_EQ(diff.facts[0].name, "column.clearance_m");
  EXPECT_THAT(diff.facts[0].before, testing::MatchesRegex("mean [0-9.]+ m"));
  EXPECT_THAT(
      diff.facts[0].after,
      testing::MatchesRegex("mean [0-9.]+ m, different at 1 of 40 places, by at most 2.5 m"));
  EXPECT_EQ(diff.facts[1].name, "column.kind");
  EXPECT_EQ(diff.facts[1].after, "");
  EXPECT_EQ(diff.facts[2].name, "column.sort");
  EXPECT_EQ(diff.facts[2].before, "");
}

TEST(MapDiff, SaysWhereGridsCannotBeCompared) {
  const CompiledMap map = random_map({.seed = 3});
  CompiledMap changed = random_map({.seed = 3, .tile_m = 32.0});
  const MapDiff diff = diff_of(map, changed);
  EXPECT_FALSE(diff.has_comparable_nds);
  EXPECT_TRUE(diff.nds.empty());
  EXPECT_TRUE(diff.sites.empty()) << "the sites are the same in both";
  EXPECT_THAT(diff.facts, Contains(Field(&FactDiff::name, "tile_m")));
}

TEST(MapDiff, OfALimitThatIsNewSaysThatTheOldMapHadNone) {
  const CompiledMap map = random_map({.seed = 4, .limits_m = {0.10}});
  const MapDiff diff = diff_of(map, random_map({.seed = 4, .limits_m = {0.10, 0.5}}));
  ASSERT_THAT(diff.limits, SizeIs(2));
  EXPECT_TRUE(diff.limits[0].is_common());
  EXPECT_FALSE(diff.limits[1].before.has_value());
  EXPECT_TRUE(diff.limits[1].after.has_value());
}

TEST(MapDiff, OfABrokenMapNamesTheFile) {
  const std::filesystem::path folder = scratch_folder();
  std::vector<std::byte> file = encode_map(random_map({.seed = 9}));
  ASSERT_TRUE(write_file_atomically(folder / "old.slmap", file, IfExists::kReplace));
  file[40] ^= std::byte{1};
  ASSERT_TRUE(write_file_atomically(folder / "new.slmap", file, IfExists::kReplace));
  const Error error =
      failure_of(diff_maps(folder / "old.slmap", folder / "new.slmap", MapDiffOptions()));
  EXPECT_EQ(error.code, ErrorCode::kChecksumMismatch);
  EXPECT_EQ(error.file, (folder / "new.slmap").string());
}

}  // namespace
}  // namespace sightline
