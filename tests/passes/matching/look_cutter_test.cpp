#include "passes/matching/look_cutter.h"

#include <gtest/gtest.h>
#include <cmath>
#include <map>
#include <set>

#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

Scan room_scan(std::uint64_t seed, std::size_t count) {
  Scan scan;
  scan.points_m = room_points(seed, count, 0.02);
  return scan;
}

const Localizer& room_localizer() {
  static const Localizer kLocalizer =
      make_localizer(room_map(), localizer_options(LocalizerKind::kSearching));
  return kLocalizer;
}

// As the definition says it, return by return.
std::uint32_t scrambled(std::uint32_t h) {
  h = (h ^ (h >> 16)) * 0x85ebca6bU;
  h = (h ^ (h >> 13)) * 0xc2b2ae35U;
  return h ^ (h >> 16);
}

std::vector<Eigen::Vector3d> candidates_by_definition(const std::vector<Eigen::Vector3d>& points_m,
                                                      const Look& look) {
  const auto step = static_cast<std::uint64_t>(std::ldexp(look_stride(look, points_m.size()), 32));
  std::vector<Eigen::Vector3d> kept_m;
  std::set<CellKey> voxels;
  for (std::uint64_t n = 0; (n * step) >> 32 < points_m.size(); ++n) {
    const std::uint64_t index = (n * step) >> 32;
    const Eigen::Vector3d& point_m = points_m[index];
    if (point_m.norm() > look.range_m) continue;
    const double chance = std::ldexp(scrambled(static_cast<std::uint32_t>(index)), -32);
    const double ratio = point_m.norm() / look.even_beyond_m;
    if (look.even_beyond_m > 0.0 && chance >= ratio * ratio) continue;
    if (voxels.insert(cell_key(point_m, 1.0)).second) kept_m.push_back(point_m);
  }
  return kept_m;
}

Look random_sample(Random& random) {
  Look look{.range_m = random.uniform(3.0, 25.0),
            .return_count = static_cast<std::uint32_t>(1 + random.below(8000))};
  if (random.below(2) > 0) look.even_beyond_m = random.uniform(1.0, 20.0);
  return look;
}

TEST(LookCutter, TakesTheFirstReturnOfEachVoxelAsItsDefinitionSays) {
  Random random(4);
  LookCutter cutter;  // one for all: nothing of a scan may be left in the next
  for (int trial = 0; trial < 60; ++trial) {
    const Scan scan = room_scan(random.next(), random.below(6000));
    const Look look = random_sample(random);
    const std::span<const Eigen::Vector3d> found_m = cutter.candidates(scan.points_m, look);
    const std::vector<Eigen::Vector3d> expected_m = candidates_by_definition(scan.points_m, look);
    EXPECT_EQ(std::vector<Eigen::Vector3d>(found_m.begin(), found_m.end()), expected_m)
        << to_text(look);
  }
}

TEST(LookCutter, KeepsNearReturnsWithTheSquareOfTheirDistance) {
  Random random(6);
  Scan scan;  // far apart: each in a voxel of its own
  for (int i = 0; i < 40000; ++i) {
    const double r_m = i % 2 == 0 ? 10.0 : 40.0;
    scan.points_m.push_back(r_m * random_vector(random, -1.0, 1.0).normalized());
  }
  LookCutter cutter(0.01);
  const Look look{.range_m = 50.0, .return_count = 40000, .even_beyond_m = 30.0};
  std::size_t near = 0, far = 0;
  for (const Eigen::Vector3d& point_m : cutter.candidates(scan.points_m, look)) {
    ++(point_m.norm() < 20.0 ? near : far);
  }
  EXPECT_NEAR(static_cast<double>(near) / 20000.0, 1.0 / 9.0, 0.01);
  EXPECT_GT(far, 19900U);
}

TEST(LookCutter, OfEveryReturnIsTheScanCutter) {
  const Scan scan = room_scan(9, 5000);
  LookCutter cutter;
  ScanForMatch cut;
  cutter.cut(room_localizer(), scan, {}, every_return(12.0), Pose::Identity(), cut);
  const ScanForMatch expected =
      make_scan_for_match(room_localizer(), voxel_subsample(crop(scan.points_m, 12.0), 1.0));
  EXPECT_EQ(cut.points_m, expected.points_m);
  EXPECT_EQ(cut.thin_count, expected.thin_count);
}

TEST(LookCutter, SpreadsItsPointsOverTheCandidates) {
  const Scan scan = room_scan(10, 5000);
  Look look{.range_m = 30.0, .return_count = 3000};
  LookCutter cutter;
  const std::span<const Eigen::Vector3d> all = cutter.candidates(scan.points_m, look);
  const std::vector<Eigen::Vector3d> all_m(all.begin(), all.end());
  look.point_count = 50;
  ScanForMatch cut;
  cutter.cut(room_localizer(), scan, {}, look, Pose::Identity(), cut);
  ASSERT_EQ(cut.points_m.size(), 50U);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(cut.points_m[i], all_m[i * all_m.size() / 50]);
}

// The first ND among the cell's own and its neighbours', as the grid lists them.
std::size_t class_at(const Eigen::Vector3d& p_map_m) {
  const MatchGrid& grid = *room_localizer().levels.back().grid;
  const std::int32_t cell = find_cell(grid, cell_key(p_map_m, grid.cell_m));
  if (cell == MatchGrid::kNone) return kNormalClasses;
  for (const std::int32_t nd : grid.neighbourhoods[static_cast<std::size_t>(cell)]) {
    if (nd == MatchGrid::kNone) continue;
    return normal_class(room_map().nds[static_cast<std::size_t>(nd)].eigenvectors.col(2));
  }
  return kNormalClasses;
}

// Groups by direction and distance, one point of each in turn, as the definition says it.
std::vector<Eigen::Vector3d> by_normals_by_definition(const std::vector<Eigen::Vector3d>& all_m,
                                                      std::size_t point_count) {
  std::vector<Eigen::Vector3d> candidates_m = all_m;
  if (all_m.size() > 4 * point_count) {
    candidates_m.clear();
    for (std::size_t k = 0; k < 4 * point_count; ++k) {
      candidates_m.push_back(all_m[k * all_m.size() / (4 * point_count)]);
    }
  }
  std::map<std::pair<std::size_t, bool>, std::size_t> sizes, quotas;
  const auto group_of = [](const Eigen::Vector3d& p_m) {
    return std::pair(class_at(p_m), p_m.norm() > 15.0);
  };
  for (const Eigen::Vector3d& p_m : candidates_m) ++sizes[group_of(p_m)];
  std::size_t left = point_count;
  for (std::size_t before = left + 1; left > 0 && before != left;) {
    before = left;
    for (const auto& [group, size] : sizes) {
      if (group.first == kNormalClasses || left == 0 || quotas[group] == size) continue;
      ++quotas[group];
      --left;
    }
  }
  std::map<std::pair<std::size_t, bool>, std::size_t> met;
  std::vector<Eigen::Vector3d> taken_m;
  for (const Eigen::Vector3d& p_m : candidates_m) {
    const auto group = group_of(p_m);
    const std::size_t k = met[group]++, q = quotas[group], c = sizes[group];
    if ((k + 1) * q / c > k * q / c) taken_m.push_back(p_m);
  }
  return taken_m;
}

TEST(LookCutter, TakesPointsInTurnFromAllDirectionsOfNormals) {
  for (const std::uint32_t point_count : {1U, 7U, 100U, 300U, 5000U}) {
    const Scan scan = room_scan(11, 6000);
    Look look{.range_m = 30.0, .return_count = 6000};
    LookCutter cutter;
    const std::span<const Eigen::Vector3d> all = cutter.candidates(scan.points_m, look);
    const std::vector<Eigen::Vector3d> expected_m =
        by_normals_by_definition({all.begin(), all.end()}, point_count);
    look.point_count = point_count;
    look.is_by_normals = true;
    ScanForMatch cut;
    cutter.cut(room_localizer(), scan, {}, look, Pose::Identity(), cut);
    ASSERT_EQ(cut.points_m.size(), expected_m.size());
    EXPECT_EQ(std::set(cut.x_m.begin(), cut.x_m.begin() + static_cast<long>(expected_m.size())),
              [&] {
                std::set<double> xs;
                for (const Eigen::Vector3d& p_m : expected_m) xs.insert(p_m.x());
                return xs;
              }());
  }
}

TEST(LookCutter, AllocatesNothingOnceItHasCutSuchAScan) {
  const Scan scan = room_scan(12, 5000);
  const Look look{.range_m = 30.0, .return_count = 2000, .point_count = 80, .is_by_normals = true};
  LookCutter cutter;
  ScanForMatch cut;
  cutter.cut(room_localizer(), scan, {}, look, Pose::Identity(), cut);
  const std::size_t before = allocation_count();
  cutter.cut(room_localizer(), scan, {}, look, Pose::Identity(), cut);
  EXPECT_EQ(allocation_count(), before);
}

TEST(LookCutter, OfNothingIsNothing) {
  LookCutter cutter;
  ScanForMatch cut;
  cutter.cut(room_localizer(), Scan{}, {}, Look{.return_count = 100}, Pose::Identity(), cut);
  EXPECT_TRUE(cut.points_m.empty());
}

TEST(NormalClass, TellsFourAzimuthsAndUprightApart) {
  Random random(8);
  for (int trial = 0; trial < 1000; ++trial) {
    const Eigen::Vector3d normal = random_vector(random, -1.0, 1.0).normalized();
    EXPECT_EQ(normal_class(normal), normal_class(-normal));
    EXPECT_LT(normal_class(normal), kNormalClasses);
  }
  std::set<int> met;
  for (const double azimuth_deg : {0.0, 45.0, 90.0, 135.0}) {
    for (const double off_deg : {-20.0, 0.0, 20.0}) {
      const double rad = (azimuth_deg + off_deg) * std::acos(-1.0) / 180.0;
      met.insert(normal_class({std::cos(rad), std::sin(rad), 0.1}));
    }
  }
  EXPECT_EQ(met.size(), 4U);
  EXPECT_EQ(met.count(normal_class(Eigen::Vector3d::UnitZ())), 0U);
}

TEST(LookCutter, PreparedOnceEndsFromEachStartAsIfCutAnew) {
  Random random(31);
  const SensorProfile sensor;
  LookCutter prepared;
  LookCutter anew;
  for (const bool is_by_normals : {false, true}) {
    const Scan scan = room_scan(random.next(), 6000);
    const Look look{
        .range_m = 20.0, .return_count = 3000, .point_count = 40, .is_by_normals = is_by_normals};
    prepared.prepare(scan, look);
    for (int start = 0; start < 5; ++start) {
      const Pose T_map_start(Eigen::Translation3d(random.uniform(-3.0, 3.0), 0.5 * start, 0.0));
      ScanForMatch after, whole;
      prepared.finish(room_localizer(), sensor, T_map_start, after);
      anew.cut(room_localizer(), scan, sensor, look, T_map_start, whole);
      EXPECT_FALSE(whole.points_m.empty());
      EXPECT_EQ(after.points_m, whole.points_m);
    }
  }
}

}  // namespace
}  // namespace sightline
