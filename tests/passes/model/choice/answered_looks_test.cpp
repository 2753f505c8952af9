#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
#include "tests/support/handmade_model.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

// Looks of kinds of place, answered site by site.

namespace sightline {
namespace {

// 40 blocks of 60 sites, by two looks, each site with its kind.
struct Street {
  std::vector<HandmadeSite> sites;
  std::vector<PlaceKind> kinds;  // kForest, kOpen or kOpenRoad
  std::uint32_t block_count = 40;
};

RangeTable chosen_for(const Street& street) {
  ErrorModel model = handmade_model(street.sites, street.block_count);
  FactorTable factors;
  factors.looks = {{.range_m = 100.0, .return_count = 400, .point_count = 32},
                   {.range_m = 100.0, .return_count = 650, .point_count = 40}};
  factors.factors = {"own_error", "virtual_points", "occupancy_ratio",
                     "d1_ratio",  "crlb_min",       "crlb_max"};
  factors.site_count = static_cast<std::uint32_t>(street.sites.size());
  for (std::size_t site = 0; site < street.sites.size(); ++site) {
    model.sites[site].kind = street.kinds[site];
    const double edges = street.kinds[site] == PlaceKind::kForest ? 0.4 : 0.1;
    for (std::size_t look = 0; look < 2; ++look) {
      const double cost = look == 0 ? 200.0 : 400.0;
      const double error_m = street.sites[site].error_m[look];
      const double weak_m = street.kinds[site] == PlaceKind::kOpenRoad ? 0.02 : 0.001;
      factors.values.insert(factors.values.end(), {error_m, cost, 0.4, edges, 0.001, weak_m});
    }
  }
  model.out_of_fold.looks = factors.looks;
  model.out_of_fold.mean_m = model.measured_mean_m;  // it explains what it is to explain
  return *of_ranges(
      choose_ranges(TestContext(), {}, sites_of(model), model.out_of_fold, model, factors));
}

bool is_unmet(const RangeTable& table, std::size_t site) {
  return (table.flags_of(site, 0) & kUnmet) != 0;
}

// Every tenth block is hopeless.
TEST(AnsweredLooks, AreAnsweredByTheSitesOwnProbability) {
  Street street;
  for (std::size_t site = 0; site < 2400; ++site) {
    const bool is_hopeless = site / 60 % 10 == 3;
    street.sites.push_back(is_hopeless ? HandmadeSite{{0.2, 0.3}, {0.4, 0.3}}
                                       : HandmadeSite{{0.97, 0.98}, {0.05, 0.04}});
    street.kinds.push_back(PlaceKind::kForest);
  }
  const RangeTable table = chosen_for(street);
  for (std::size_t site = 0; site < 2400; ++site) {
    EXPECT_EQ(table.range(site, 0), 0) << site;
    EXPECT_EQ(is_unmet(table, site), site / 60 % 10 == 3) << site;
  }
  EXPECT_TRUE(table.promises[0].is_earned) << table.promises[0].statement;
  EXPECT_NEAR(table.promises[0].answered_share, 0.9, 1e-12);
  EXPECT_EQ(table.promises[0].calibration_miss_share, 0.0);
  EXPECT_EQ(table.dilation_m, 0.0);
}

// Open stretches of 120 m need the second look; p* is set with the looks that sites take.
TEST(AnsweredLooks, DifferBetweenKindsInTheMapAndInTheCalibration) {
  Street street;
  for (std::size_t site = 0; site < 2400; ++site) {
    const bool is_open = site / 120 % 2 == 1;
    street.kinds.push_back(is_open ? PlaceKind::kOpen : PlaceKind::kForest);
    street.sites.push_back(is_open ? HandmadeSite{{0.2, 0.97}, {0.16, 0.01}}
                                   : HandmadeSite{{0.97, 0.98}, {0.01, 0.01}});
  }
  const RangeTable table = chosen_for(street);
  for (std::size_t site = 0; site < 2400; ++site) {
    EXPECT_EQ(table.range(site, 0), site / 120 % 2) << site;
    EXPECT_FALSE(is_unmet(table, site)) << site;
  }
  EXPECT_TRUE(table.promises[0].is_earned) << table.promises[0].statement;
  EXPECT_EQ(table.promises[0].answered_share, 1.0);
}

// In the forest a probability of 0.8 always holds; on the road one of 0.85 never does.
TEST(AnsweredLooks, HaveAThresholdOfEachGroupOfPlacesWhereBothHaveEnoughBlocks) {
  for (const std::uint32_t block_count : {80U, 60U}) {
    Street street;
    street.block_count = block_count;
    for (std::size_t site = 0; site < 60 * block_count; ++site) {
      const bool is_road = site / 120 % 2 == 1;  // both drives pass each
      const bool is_doubtful = is_road && site % 60 >= 45;
      street.kinds.push_back(is_road ? PlaceKind::kOpenRoad : PlaceKind::kForest);
      street.sites.push_back(is_doubtful ? HandmadeSite{{0.85, 0.86}, {0.3, 0.3}}
                             : is_road   ? HandmadeSite{{0.97, 0.98}, {0.05, 0.05}}
                                         : HandmadeSite{{0.8, 0.81}, {0.05, 0.05}});
    }
    const RangeTable table = chosen_for(street);
    const bool has_groups = block_count == 80;
    for (std::size_t site = 0; site < street.sites.size(); ++site) {
      const bool is_forest = street.kinds[site] == PlaceKind::kForest;
      const bool is_doubtful = !is_forest && site % 60 >= 45;
      EXPECT_EQ(is_unmet(table, site), is_doubtful || (is_forest && !has_groups)) << site;
    }
    EXPECT_TRUE(table.promises[0].is_earned) << table.promises[0].statement;
    EXPECT_EQ(table.promises[0].calibration_miss_share, 0.0);
    EXPECT_NEAR(table.promises[0].answered_share, has_groups ? 0.875 : 0.375, 1e-9);
    EXPECT_EQ(table.promises[0].statement.starts_with("Outside tunnels, corridors"), has_groups);
  }
}

}  // namespace
}  // namespace sightline
