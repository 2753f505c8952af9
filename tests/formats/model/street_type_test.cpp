#include "formats/model/street_type.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

// One site; occupancy at 10, 15, 20, 30, 50 m.
StreetType type_at(const std::vector<double>& occupancy) {
  FactorTable factors;
  factors.looks = every_return_at({10.0, 15.0, 20.0, 30.0, 50.0});
  factors.factors = {"feature_count", "occupancy_ratio"};
  factors.site_count = 1;
  for (const double share : occupancy) {
    factors.values.push_back(7.0);
    factors.values.push_back(share);
  }
  return street_types(factors).front();
}

TEST(StreetType, IsToldByHowFarASiteSees) {
  EXPECT_EQ(type_at({0.75, 0.85, 0.90, 0.92, 0.95}), StreetType::kLane);
  EXPECT_EQ(type_at({0.45, 0.75, 0.82, 0.88, 0.92}), StreetType::kCanyon);
  EXPECT_EQ(type_at({0.18, 0.33, 0.40, 0.60, 0.82}), StreetType::kAvenue);
  EXPECT_EQ(type_at({0.16, 0.30, 0.35, 0.42, 0.60}), StreetType::kOpen);
}

TEST(StreetType, ACrossingHasWallsNearAndStreetsThatLeadAway) {
  EXPECT_EQ(type_at({0.20, 0.45, 0.55, 0.62, 0.70}), StreetType::kCrossing);
  EXPECT_EQ(type_at({0.20, 0.45, 0.55, 0.62, 0.80}), StreetType::kAvenue) << "closed at its end";
}

TEST(StreetType, BoundsBelongToTheNarrowerType) {
  EXPECT_EQ(type_at({2.0 / 3.0, 0.7, 0.7, 0.7, 0.7}), StreetType::kLane);
  EXPECT_EQ(type_at({0.1, 0.5, 0.8, 0.8, 0.8}), StreetType::kCanyon);
  EXPECT_EQ(type_at({0.1, 0.1, 0.1, 0.5, 0.9}), StreetType::kAvenue);
}

TEST(StreetType, WiderViewsNeverMakeANarrowerStreet) {
  Random random(3);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> near;
    double share = 0.0;
    for (int range = 0; range < 5; ++range) near.push_back(share += random.uniform(0.0, 0.2));
    near.back() = std::max(near.back(), 0.8);  // no crossing
    std::vector<double> wide = near;
    for (std::size_t i = 0; i + 1 < wide.size(); ++i) wide[i] *= 0.7;
    EXPECT_LE(static_cast<int>(type_at(near)), static_cast<int>(type_at(wide)));
  }
}

TEST(StreetType, IsUnknownWithoutTheFactor) {
  FactorTable factors;
  factors.looks = every_return_at({10.0});
  factors.factors = {"feature_count"};
  factors.site_count = 2;
  factors.values = {1.0, 2.0};
  EXPECT_EQ(street_types(factors),
            (std::vector<StreetType>{StreetType::kUnknown, StreetType::kUnknown}));
  EXPECT_TRUE(street_types(FactorTable{}).empty());
}

}  // namespace
}  // namespace sightline
