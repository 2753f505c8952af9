#include "passes/localize/area_localizers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/localizer.h"

namespace sightline {
namespace {

NdtMap long_lane() {
  Random random(3);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 200000; ++i) {
    const double x_m = random.uniform(-300.0, 300.0);
    const double shift_m = std::fmod(std::abs(x_m), 13.0) < 2.0 ? 1.0 : 0.0;
    points_m.emplace_back(x_m, 5.0 - shift_m, random.uniform(-2.0, 4.0));
    points_m.emplace_back(x_m, random.uniform(-5.0, 5.0), -2.0 + 0.02 * random.normal());
  }
  return ndt_from_points(points_m, MapFrame{}, {}, 1);
}

std::vector<Eigen::Vector3d> scan_at(const Eigen::Vector3d& p_m, const NdtMap& map) {
  std::vector<Eigen::Vector3d> points_m;
  for (const Nd& nd : map.nds) {
    if ((nd.mean_m - p_m).norm() < 50.0) points_m.push_back(nd.mean_m - p_m);
  }
  return points_m;
}

void expect_same(const Localizer& a, const Localizer& b, const Eigen::Vector3d& p_m,
                 const NdtMap& map) {
  const std::vector<Eigen::Vector3d> points_m = scan_at(p_m, map);
  for (const double off_m : {0.0, 0.7, 8.0}) {
    Pose T_map_start = Pose::Identity();
    T_map_start.translation() = p_m + Eigen::Vector3d(off_m, -0.2, 0.0);
    ScanForMatch scan = make_scan_for_match(a, points_m);
    const MatchResult of_a = localize(a, scan, T_map_start);
    scan = make_scan_for_match(b, points_m);
    const MatchResult of_b = localize(b, scan, T_map_start);
    EXPECT_EQ(of_a.T_map_sensor.matrix(), of_b.T_map_sensor.matrix());
    EXPECT_EQ(of_a.score, of_b.score);
    EXPECT_EQ(of_a.work, of_b.work);
    EXPECT_GT(of_a.scored_points, 0U);
  }
}

TEST(AreaLocalizers, FindWhatALocalizerOfTheWholeMapFindsToTheBit) {
  const NdtMap map = long_lane();
  for (const LocalizerKind kind : {LocalizerKind::kPlain, LocalizerKind::kSearching}) {
    for (const int coarse_cells : {1, 2}) {
      AreaLocalizers areas(map, {kind, coarse_cells, 50.0, 2});
      const Localizer own = make_localizer(map, localizer_options(kind, coarse_cells));
      const Localizer of_samples = make_localizer(map, options_for_samples(coarse_cells));
      // The last two are served by the area of the one before, from beyond its edge.
      for (const double x_m : {-130.0, -63.9, 0.1, 65.0, 141.0, 50.0}) {
        const Eigen::Vector3d p_m(x_m, 0.3, 0.0);
        const std::shared_ptr<const AreaLocalizer> area = *areas.at(p_m);
        expect_same(area->own, own, p_m, map);
        expect_same(area->of_samples, of_samples, p_m, map);
        EXPECT_LT(area->own.levels[0].grid->nds.size(), own.levels[0].grid->nds.size());
      }
    }
  }
}

TEST(AreaLocalizers, KeepTheLatestAreasReady) {
  const NdtMap map = long_lane();
  AreaLocalizers areas(map, {LocalizerKind::kPlain, 1, 10.0, 2});
  const std::weak_ptr<const AreaLocalizer> first = *areas.at({10.0, 0.0, 0.0});
  const std::weak_ptr<const AreaLocalizer> second = *areas.at({90.0, 0.0, 0.0});
  EXPECT_EQ(*areas.at({40.0, 3.0, 0.0}), first.lock());
  (void)areas.at({200.0, 0.0, 0.0});
  EXPECT_TRUE(second.expired());
  EXPECT_FALSE(first.expired());
}

TEST(AreaLocalizers, KeepAnAreaForEachOfAllThreads) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one thread";
  const NdtMap map = long_lane();
  AreaLocalizers areas(map, {LocalizerKind::kPlain, 1, 10.0, /*threads=*/0});
  const std::shared_ptr<const AreaLocalizer> first = *areas.at({10.0, 0.0, 0.0});
  (void)areas.at({200.0, 0.0, 0.0});
  EXPECT_EQ(*areas.at({10.0, 0.0, 0.0}), first);
}

TEST(AreaLocalizers, AreNotMadeAnewAlongAnEdgeBetweenTwoAreas) {
  const NdtMap map = long_lane();
  AreaLocalizers areas(map, {LocalizerKind::kPlain, 1, 10.0, 1});
  const std::shared_ptr<const AreaLocalizer> first = *areas.at({1.0, 0.1, 0.0});
  for (int i = 1; i < 60; ++i) {
    EXPECT_EQ(*areas.at({1.0 + i, i % 2 == 0 ? 0.2 : -0.2, 0.0}), first) << i;
  }
  EXPECT_NE(*areas.at({81.0, -0.2, 0.0}), first);
}

TEST(AreaLocalizers, AreMadeOnceForAllThatAskAtOnce) {
  const NdtMap map = long_lane();
  AreaLocalizers areas(map, {LocalizerKind::kPlain, 1, 10.0, 4});
  std::vector<std::shared_ptr<const AreaLocalizer>> found(8);
  parallel_for(found.size(), 4, [&](std::size_t i) {
    found[i] = *areas.at({i % 2 == 0 ? 10.0 : 200.0, 0.0, 0.0});
  });
  for (std::size_t i = 2; i < found.size(); ++i) EXPECT_EQ(found[i], found[i - 2]) << i;
  EXPECT_NE(found[0], found[1]);
}

}  // namespace
}  // namespace sightline
