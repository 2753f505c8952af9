#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/gate/rules/map_figures.h"
#include "formats/base/random.h"
#include "tests/compiler/gate/gate_on_map.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/formats/map/random_map.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(GateOnTwoMaps, FindsNothingBetweenAMapAndItself) {
  const CompiledMap map = route_map(120);
  EXPECT_TRUE(violations(judged(map, &map)).empty());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const CompiledMap any = random_map({.seed = seed});
    for (const Check& check : judged(any, &any).checks) {
      if (check.rule.find("rise") != std::string::npos ||
          check.rule.find("change") != std::string::npos ||
          check.rule.find("drop") != std::string::npos) {
        EXPECT_NE(check.verdict, Verdict::kViolated) << check.message;
      }
    }
  }
}

// Of 120 sites, 30 expect 9 instead of 5 cm, look 50 instead of 10 m and are unmet.
TEST(GateOnTwoMaps, NamesRulePlaceAndNumbersOfAStretchThatGotWorse) {
  const CompiledMap old_map = route_map(120);
  CompiledMap map = old_map;
  for (std::size_t site = 60; site < 90; ++site) set_site(map, site, {2, 0.09, 0.6, kUnmet});
  sum_up(map);
  const GateReport report = judged(map, &old_map);
  for (const auto& [rule, found] :
       {std::pair("stretch-error-rise", 0.4), std::pair("stretch-range-rise", 40.0),
        std::pair("stretch-coverage-drop", 0.35), std::pair("stretch-unmet", 30.0)}) {
    const std::vector<Check> checks = checks_of(report, rule, 0.1);
    ASSERT_EQ(checks.size(), 1u) << rule;
    EXPECT_EQ(checks[0].verdict, Verdict::kViolated) << rule;
    EXPECT_NEAR(checks[0].found, found, 1e-9) << rule;
    ASSERT_TRUE(checks[0].place) << rule;
    EXPECT_EQ(checks[0].place->first_site, 60u) << rule;
    EXPECT_EQ(checks[0].place->last_site, 89u) << rule;
  }
  EXPECT_THAT(checks_of(report, "stretch-range-rise", 0.1)[0].message,
              HasSubstr("the range within 0.1 m was 10.0 m and is 50.0 m over the worst 20 m"));
  // 0.04 m are 0.16 of the looser limit: allowed is 0.25.
  EXPECT_EQ(checks_of(report, "stretch-error-rise", 0.25).at(0).verdict, Verdict::kMet);
  EXPECT_NEAR(checks_of(report, "mean-range-rise", 0.1).at(0).found, 10.0, 1e-9);
  EXPECT_NEAR(checks_of(report, "coverage-drop", 0.1).at(0).found, 0.0875, 1e-9);
  EXPECT_NEAR(checks_of(report, "unmet-rise", 0.1).at(0).found, 0.25, 1e-9);
  EXPECT_NEAR(checks_of(report, "work-rise", 0.1).at(0).found, 0.2, 1e-9);
  EXPECT_FALSE(report.passes());
  EXPECT_TRUE(judged(old_map, &map).passes()) << "what got better is no finding";
}

TEST(GateOnTwoMaps, BelieveWhatWasMeasuredWhereTheModelSeesNoChange) {
  CompiledMap old_map = route_map(120);
  old_map.measurement.measured_site_count = 120;
  old_map.quality[0].measured_coverage = 0.95;
  CompiledMap map = old_map;
  map.quality[0].measured_coverage = 0.90;
  const Check dropped = checks_of(judged(map, &old_map), "measured-coverage-drop", 0.1).at(0);
  EXPECT_EQ(dropped.verdict, Verdict::kViolated);
  EXPECT_NEAR(dropped.found, 0.05, 1e-12);
  EXPECT_EQ(checks_of(judged(old_map, &map), "measured-coverage-drop", 0.1).at(0).verdict,
            Verdict::kMet);
  map.measurement.measured_site_count = 0;
  EXPECT_EQ(checks_of(judged(map, &old_map), "measured-coverage-drop").at(0).verdict,
            Verdict::kNotJudged);
}

TEST(GateOnTwoMaps, ComparesTheSamePlaceWhereTheFrameMovedAndRouteIsGone) {
  const CompiledMap old_map = route_map(120);
  CompiledMap map = route_map(80);  // the last 40 m are gone
  map.ndt.frame.origin_world_m.x() += 64.0;
  map.sites.frame = map.ndt.frame;
  for (Site& site : map.sites.sites) site.p_map_m.x() -= 64.0;
  const GateReport report = judged(map, &old_map);
  EXPECT_EQ(checks_of(report, "frame-change").at(0).verdict, Verdict::kViolated);
  EXPECT_THAT(checks_of(report, "frame-change")[0].message,
              HasSubstr("origin (640, -64, 0) became (704, -64, 0)"));
  EXPECT_NEAR(checks_of(report, "stretch-range-rise", 0.1).at(0).found, 0.0, 1e-12);
  // The last site stands for 10 m around it.
  const Check lost = checks_of(report, "route-lost").at(0);
  EXPECT_EQ(lost.verdict, Verdict::kViolated);
  EXPECT_TRUE(lost.place->is_of_old);
  EXPECT_EQ(lost.place->first_site, 90u);
  EXPECT_EQ(lost.place->last_site, 119u);
  EXPECT_NEAR(lost.found, 30.0, 1e-9);
}

TEST(GateOnTwoMaps, NamesWhatIsOfAnotherKind) {
  const CompiledMap old_map = route_map(30);
  CompiledMap map = old_map;
  map.release = old_map.release - 1;
  map.definitions = {{"ndt-map", 2}, {"sites", 1}, {"sights", 1}};
  map.sensor.max_range_m += 1.0;
  map.ranges.selection = Selection::kMean;
  map.model.digest[0] = static_cast<std::uint8_t>(map.model.digest[0] + 1);
  map.predicted.out_of_fold.assign(30, 1);
  const GateReport report = judged(map, &old_map);
  EXPECT_EQ(checks_of(report, "release-order").at(0).found, -1.0);
  EXPECT_EQ(checks_of(report, "definition-change").at(0).found, 2.0);
  EXPECT_THAT(checks_of(report, "definition-change")[0].message, HasSubstr("ndt-map v1 became v2"));
  EXPECT_EQ(checks_of(report, "sensor-change").at(0).found, 1.0);
  const Check model = checks_of(report, "model-change").at(0);
  EXPECT_EQ(model.found, 2.0);
  EXPECT_EQ(model.severity, Severity::kNote);
  EXPECT_THAT(model.message, HasSubstr("of 30 became 30 of 30"));
  EXPECT_EQ(checks_of(report, "limits-change").at(0).verdict, Verdict::kViolated);
}

TEST(SitePairs, AreTheNearestSitesByBruteForce) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CompiledMap a = random_map({.seed = seed, .site_count = 60, .extent_m = 40.0});
    const CompiledMap b = random_map({.seed = seed + 100, .site_count = 60, .extent_m = 40.0});
    const SitePairs pairs = pair_sites(a, b);
    for (std::size_t i = 0; i < a.sites.sites.size(); ++i) {
      std::optional<std::uint32_t> best;
      double best_m = b.reach_m;
      for (std::uint32_t j = 0; j < b.sites.sites.size(); ++j) {
        const double away_m = (a.sites.sites[i].p_map_m + a.sites.frame.origin_world_m -
                               b.sites.sites[j].p_map_m - b.sites.frame.origin_world_m)
                                  .norm();
        if (best ? away_m < best_m : away_m <= best_m) {
          best = j;
          best_m = away_m;
        }
      }
      EXPECT_EQ(pairs.old_of_new[i], best) << "seed " << seed << " site " << i;
    }
  }
}

// Every window by its own sum, against the running one.
TEST(Stretches, WorstIsTheWorstOfAllWindowsAndEveryBadWindowTouchesABadStretch) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const Sites sites = random_map({.seed = seed, .site_count = 120, .run_count = 3}).sites;
    std::vector<double> value;
    for (std::size_t i = 0; i < sites.sites.size(); ++i) value.push_back(random.uniform());
    const StretchSearch search{7.0, Bound::kAtMost};
    double worst = -1.0;
    const std::vector<BadStretch> bad = bad_stretches(sites, value, search, 0.7);
    for (std::size_t first = 0; first < value.size(); ++first) {
      double sum = 0.0;
      for (std::size_t last = first; last < value.size(); ++last) {
        const double length_m = sites.sites[last].s_m - sites.sites[first].s_m;
        if (sites.sites[last].run != sites.sites[first].run || length_m > 7.0) break;
        sum += value[last];
        if (length_m < 7.0) continue;
        const double mean = sum / static_cast<double>(last - first + 1);
        worst = std::max(worst, mean);
        if (mean <= 0.7) continue;
        EXPECT_TRUE(std::ranges::any_of(bad,
                                        [&](const BadStretch& stretch) {
                                          return stretch.first <= last && stretch.last >= first;
                                        }))
            << "seed " << seed << " sites " << first << " to " << last;
      }
    }
    EXPECT_NEAR(worst_stretch(sites, value, search).worst, worst, 1e-12) << "seed " << seed;
    for (const BadStretch& stretch : bad) EXPECT_GT(stretch.worst, 0.7);
  }
}

}  // namespace
}  // namespace sightline
