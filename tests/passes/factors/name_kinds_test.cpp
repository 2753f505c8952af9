#include "passes/factors/name_kinds.h"

#include <gtest/gtest.h>

#include "formats/model/place_kind.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

struct Road {
  Sites sites;
  FactorTable factors;
};

// A site every metre, all of which see as much.
Road road_of(std::uint32_t site_count) {
  Road road;
  road.factors.looks = every_return_at({10.0, 15.0, 20.0, 30.0, 50.0});
  road.factors.factors = {"occupancy_ratio"};
  road.factors.site_count = site_count;
  for (std::uint32_t i = 0; i < site_count; ++i) {
    road.sites.sites.push_back({0, static_cast<double>(i), Pose::Identity(), {}});
    for (const double share : {0.45, 0.75, 0.82, 0.88, 0.92}) road.factors.values.push_back(share);
  }
  return road;
}

TEST(NameKinds, IsAColumnOfNumbersThatANameBelongsTo) {
  const Road road = road_of(600);  // more than are read at once
  const SiteColumn column = value_of(name_kinds(TestContext(), {}, road.sites, road.factors));
  EXPECT_TRUE(validate(column).has_value());
  EXPECT_EQ(column.name, kPlaceKindColumn);
  EXPECT_EQ(column.steps.size(), kPlaceKindCount);
  ASSERT_EQ(column.values.size(), 600U);
  for (std::size_t i = 0; i < 600; ++i) {
    EXPECT_EQ(kind_at({column}, i), place_kinds(road.factors)[i]) << i;
  }
  EXPECT_NE(kind_at({column}, 0), PlaceKind::kUnknown);
}

TEST(NameKinds, RefusesFactorsOfOtherSites) {
  Road road = road_of(3);
  road.sites.sites.pop_back();
  EXPECT_EQ(failure_of(name_kinds(TestContext(), {}, road.sites, road.factors)).code,
            ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
