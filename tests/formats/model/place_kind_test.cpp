#include "formats/model/place_kind.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

// One site; occupancy at 10, 15, 20, 30, 50 m.
PlaceKind type_at(const std::vector<double>& occupancy) {
  FactorTable factors;
  factors.looks = every_return_at({10.0, 15.0, 20.0, 30.0, 50.0});
  factors.factors = {"feature_count", "occupancy_ratio"};
  factors.site_count = 1;
  for (const double share : occupancy) {
    factors.values.push_back(7.0);
    factors.values.push_back(share);
  }
  return place_kinds(factors).front();
}

TEST(PlaceKind, FollowsFromHowFarASiteSees) {
  EXPECT_EQ(type_at({0.75, 0.85, 0.90, 0.92, 0.95}), PlaceKind::kLane);
  EXPECT_EQ(type_at({0.45, 0.75, 0.82, 0.88, 0.92}), PlaceKind::kCanyon);
  EXPECT_EQ(type_at({0.18, 0.33, 0.40, 0.60, 0.82}), PlaceKind::kAvenue);
  EXPECT_EQ(type_at({0.16, 0.30, 0.35, 0.42, 0.60}), PlaceKind::kOpen);
}

TEST(PlaceKind, ACrossingHasWallsNearAndStreetsThatLeadAway) {
  EXPECT_EQ(type_at({0.20, 0.45, 0.55, 0.62, 0.70}), PlaceKind::kCrossing);
  EXPECT_EQ(type_at({0.20, 0.45, 0.55, 0.62, 0.80}), PlaceKind::kAvenue) << "closed at its end";
}

TEST(PlaceKind, BoundsBelongToTheNarrowerType) {
  EXPECT_EQ(type_at({2.0 / 3.0, 0.7, 0.7, 0.7, 0.7}), PlaceKind::kLane);
  EXPECT_EQ(type_at({0.1, 0.5, 0.8, 0.8, 0.8}), PlaceKind::kCanyon);
  EXPECT_EQ(type_at({0.1, 0.1, 0.1, 0.5, 0.9}), PlaceKind::kAvenue);
}

TEST(PlaceKind, WiderViewsNeverMakeANarrowerStreet) {
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

TEST(PlaceKind, IsByWallsWithoutBothBounds) {
  FactorTable factors;
  factors.looks = every_return_at({10.0});
  factors.factors = {"occupancy_ratio", "crlb_max"};
  factors.site_count = 1;
  factors.values = {0.9, 0.5};
  EXPECT_EQ(place_kinds(factors).front(), PlaceKind::kLane);
}

TEST(PlaceKind, IsUnknownWithoutTheFactor) {
  FactorTable factors;
  factors.looks = every_return_at({10.0});
  factors.factors = {"feature_count"};
  factors.site_count = 2;
  factors.values = {1.0, 2.0};
  EXPECT_EQ(place_kinds(factors),
            (std::vector<PlaceKind>{PlaceKind::kUnknown, PlaceKind::kUnknown}));
  EXPECT_TRUE(place_kinds(FactorTable{}).empty());
}

// What the localizer is held by, at all ranges.
struct Held {
  double weak_m = 0.006;    // crlb_max
  double strong_m = 0.002;  // crlb_min
  double edge_share = 0.1;
};

PlaceKind kind_where(const std::vector<double>& occupancy, const Held& held) {
  FactorTable factors;
  factors.looks = every_return_at({10.0, 15.0, 20.0, 30.0, 50.0});
  factors.factors = {"occupancy_ratio", "crlb_max", "crlb_min", "d1_ratio"};
  factors.site_count = 1;
  for (const double share : occupancy) {
    for (const double value : {share, held.weak_m, held.strong_m, held.edge_share}) {
      factors.values.push_back(value);
    }
  }
  return place_kinds(factors).front();
}

TEST(PlaceKind, FollowsFromWhatHoldsTheVehicle) {
  const std::vector<double> lane = {0.75, 0.85, 0.90, 0.92, 0.95};
  const std::vector<double> canyon = {0.45, 0.75, 0.82, 0.88, 0.92};
  const std::vector<double> open = {0.16, 0.30, 0.35, 0.42, 0.60};
  const std::vector<double> crossing = {0.20, 0.45, 0.55, 0.62, 0.70};
  const Held alongside = {.weak_m = 0.03};
  const Held ground = {.weak_m = 0.04, .strong_m = 0.03};
  EXPECT_EQ(kind_where(lane, {}), PlaceKind::kLane);
  EXPECT_EQ(kind_where(lane, alongside), PlaceKind::kTunnel);
  EXPECT_EQ(kind_where(canyon, {}), PlaceKind::kCanyon);
  EXPECT_EQ(kind_where(canyon, alongside), PlaceKind::kCorridor);
  EXPECT_EQ(kind_where(open, {}), PlaceKind::kOpen);
  EXPECT_EQ(kind_where(open, alongside), PlaceKind::kOpenRoad);
  EXPECT_EQ(kind_where(open, ground), PlaceKind::kField);
  EXPECT_EQ(kind_where(crossing, {}), PlaceKind::kCrossing);
  EXPECT_EQ(kind_where(crossing, alongside), PlaceKind::kOpenRoad);
  EXPECT_EQ(kind_where(canyon, {.edge_share = 0.35}), PlaceKind::kForest);
  EXPECT_EQ(kind_where(lane, ground), PlaceKind::kHall);
  EXPECT_EQ(kind_where(canyon, ground), PlaceKind::kHall);
}

// A street with a site every metre, of these kinds.
std::vector<PlaceKind> along(const std::vector<PlaceKind>& kinds) {
  Sites sites;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    sites.sites.push_back({0, static_cast<double>(i), Pose::Identity(), {}});
  }
  return smoothed(sites, kinds);
}

TEST(PlaceKind, IsThatOfTheStretch) {
  std::vector<PlaceKind> kinds(60, PlaceKind::kCanyon);
  std::fill(kinds.begin() + 30, kinds.end(), PlaceKind::kOpen);
  EXPECT_EQ(along(kinds), kinds) << "stretches keep their bounds";
  std::vector<PlaceKind> with_gaps = kinds;
  for (const std::size_t i : std::vector<std::size_t>{3, 4, 17, 44, 58})
    with_gaps[i] = PlaceKind::kLane;
  EXPECT_EQ(along(with_gaps), kinds);
}

TEST(PlaceKind, OfAnotherRunIsNoNeighbour) {
  Sites sites;
  std::vector<PlaceKind> kinds;
  for (std::uint32_t run = 0; run < 2; ++run) {
    for (int i = 0; i < (run == 0 ? 8 : 3); ++i) {
      sites.sites.push_back({run, static_cast<double>(i), Pose::Identity(), {}});
      kinds.push_back(run == 0 ? PlaceKind::kCanyon : PlaceKind::kOpen);
    }
  }
  EXPECT_EQ(smoothed(sites, kinds), kinds);
}

TEST(PlaceKind, IsReadFromTheColumnOfAMap) {
  const std::vector<SiteColumn> columns = {{std::string(kPlaceKindColumn), "", {2.0F, 99.0F}}};
  EXPECT_EQ(kind_at(columns, 0), PlaceKind::kCanyon);
  EXPECT_EQ(kind_at(columns, 1), PlaceKind::kUnknown) << "a kind of a later version";
  EXPECT_EQ(kind_at({}, 0), PlaceKind::kUnknown);
}

}  // namespace
}  // namespace sightline
