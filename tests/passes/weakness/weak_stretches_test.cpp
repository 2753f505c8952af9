#include "passes/weakness/weak_stretches.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

// Sites a metre apart: 0 to 29 of run 0, 30 to 39 of run 1, each with this margin at 0.1 m.
Sites two_runs() {
  Sites sites;
  for (int i = 0; i < 40; ++i) {
    Site site;
    site.run = i < 30 ? 0 : 1;
    site.s_m = i < 30 ? i : i - 30;
    sites.sites.push_back(site);
  }
  return sites;
}

std::vector<BestLook> margins(double margin) {
  BestLook look;
  look.margin = margin;
  return std::vector<BestLook>(40, look);
}

TEST(WeakStretches, JoinsWeakSitesOfARunThatAreNearAndPutsTheWorstFirst) {
  std::vector<BestLook> best = margins(0.8);
  for (const std::size_t site : {4U, 5U, 10U, 29U, 30U}) best[site].margin = 0.3;
  best[5].margin = 0.2;
  best[30].margin = 0.6;
  best[30].is_unmet = true;
  const std::vector<WeakStretch> found = weak_stretches(two_runs(), best, {});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].first_site, 30U);  // unmet, though its margin is the largest
  EXPECT_EQ(found[0].unmet_count, 1U);
  EXPECT_EQ(found[0].run, 1U);
  EXPECT_EQ(found[1].first_site, 4U);
  EXPECT_EQ(found[1].last_site, 10U);  // 5 m apart
  EXPECT_EQ(found[1].worst_site, 5U);
  EXPECT_EQ(found[1].from_m, 4.0);
  EXPECT_EQ(found[1].to_m, 10.0);
  EXPECT_EQ(found[2].first_site, 29U);
}

TEST(WeakStretches, TakesNoSiteAtExactlyTheMargin) {
  EXPECT_TRUE(weak_stretches(two_runs(), margins(0.5), {}).empty());
  EXPECT_EQ(weak_stretches(two_runs(), margins(0.4999), {}).size(), 2U);
}

TEST(WeakStretches, LongerThanAllowedAreToldInPieces) {
  const WeakStretchOptions options{.longest_m = 9.0};
  const std::vector<WeakStretch> found = weak_stretches(two_runs(), margins(0.1), options);
  ASSERT_EQ(found.size(), 4U);  // sites 0 to 9, 10 to 19, 20 to 29, and run 1
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].first_site, 10 * i);
    EXPECT_EQ(found[i].last_site, 10 * i + 9);
  }
}

TEST(WeakStretches, OfALargerMarginCoverNoLess) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    std::vector<BestLook> best = margins(0.0);
    for (BestLook& look : best) look.margin = random.uniform(-0.5, 1.0);
    std::size_t before = 0;
    for (const double least_margin : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      std::size_t covered = 0;
      for (const WeakStretch& stretch :
           weak_stretches(two_runs(), best, {.least_margin = least_margin, .join_m = 0.0})) {
        covered += stretch.last_site - stretch.first_site + 1;
      }
      EXPECT_GE(covered, before);
      before = covered;
    }
  }
}

TEST(BestLooks, AreOfTheLeastForetoldErrorAmongRangesAndSamples) {
  const CompiledMap map = random_map({});
  const std::vector<BestLook> best = best_looks(map, 0);
  ASSERT_EQ(best.size(), map.sites.sites.size());
  bool has_sample = false;
  for (std::size_t site = 0; site < best.size(); ++site) {
    for (const PredictedError* table : {&map.predicted, &map.looks->predicted}) {
      for (std::size_t look = 0; look < table->looks.size(); ++look) {
        EXPECT_LE(best[site].error_m, table->mean(site, look));
        if (table->looks[look] != best[site].look) continue;
        EXPECT_EQ(best[site].error_m, table->mean(site, look));
        EXPECT_EQ(best[site].probability, table->probability(site, look, 0));
      }
    }
    EXPECT_DOUBLE_EQ(best[site].margin, 1.0 - best[site].error_m / 0.1);
    const bool is_unmet = (map.ranges.flags_of(site, 0) & kUnmet) != 0 &&
                          (map.looks->ranges.flags_of(site, 0) & kUnmet) != 0;
    EXPECT_EQ(best[site].is_unmet, is_unmet);
    has_sample = has_sample || !takes_every_return(best[site].look);
  }
  EXPECT_TRUE(has_sample);
}

TEST(LimitOf, TakesTheMapsLimitsAlone) {
  const CompiledMap map = random_map({});
  EXPECT_EQ(*limit_of(map, 0.0), 0U);
  EXPECT_EQ(*limit_of(map, 0.25), 1U);
  const Error other = failure_of(limit_of(map, 0.2));
  EXPECT_EQ(other.code, ErrorCode::kBadArgument);
  EXPECT_NE(other.message.find("0.1, 0.25"), std::string::npos);
}

}  // namespace
}  // namespace sightline
