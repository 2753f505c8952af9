#include "examples/town/whole/town.h"
#include "examples/town/world/make_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

bool same_mesh(const TownMesh& a, const TownMesh& b) {
  return a.vertices_m == b.vertices_m && a.triangles == b.triangles && a.labels == b.labels;
}

Town town_of(std::uint64_t seed, double length_m) { return value_of(make_town({seed, length_m})); }

TEST(Town, ASeedMakesTheSameTrianglesAgain) {
  const Town a = town_of(7, 40.0);
  const Town b = town_of(7, 40.0);
  EXPECT_TRUE(same_mesh(standing_mesh(a, 0), standing_mesh(b, 0)));
  EXPECT_TRUE(same_mesh(standing_mesh(a, 3), standing_mesh(b, 3)));
}

TEST(Town, AnotherSeedMakesAnotherTown) {
  EXPECT_FALSE(same_mesh(town_of(7, 40.0).permanent, town_of(8, 40.0).permanent));
}

TEST(Town, EveryVertexIsFiniteAndEveryTriangleLabelled) {
  const TownMesh mesh = standing_mesh(town_of(3, 60.0), 0);
  ASSERT_EQ(mesh.labels.size(), mesh.triangles.size());
  for (const Eigen::Vector3f& vertex : mesh.vertices_m) ASSERT_TRUE(vertex.allFinite());
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.vertices_m.size());
  }
  EXPECT_TRUE(std::none_of(mesh.labels.begin(), mesh.labels.end(), is_moving));
}

TEST(Town, RefusesLengthsItCannotBuild) {
  for (const double length_m : {0.0, 19.9, -5.0, 20001.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(failure_of(make_town({1, length_m}), length_m).code, ErrorCode::kBadArgument);
  }
}

TEST(TownPlan, SixHundredMetresHoldEveryKindOfStreetInItsWidth) {
  struct Bounds {
    StreetKind kind;
    double narrowest_m, widest_m;
  };
  const std::vector<Bounds> bounds = {
      {StreetKind::kCanyon, 18, 26}, {StreetKind::kLane, 6, 8},
      {StreetKind::kPlaza, 60, 84},  {StreetKind::kSmooth, 14, 20},
      {StreetKind::kAvenue, 36, 50}, {StreetKind::kRepeating, 14, 20}};
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const TownPlan plan = make_plan(seed, 600.0);
    ASSERT_GE(plan.line.length_m(), 600.0) << seed;
    std::set<StreetKind> seen;
    for (const Street& street : plan.streets) {
      if (street.is_on_route() && street.route_from_m < 600.0) seen.insert(street.kind);
      for (const Bounds& b : bounds) {
        if (b.kind != street.kind) continue;
        EXPECT_GE(street.left_m + street.right_m, b.narrowest_m);
        EXPECT_LE(street.left_m + street.right_m, b.widest_m);
      }
    }
    EXPECT_GE(seen.size(), 6U) << "seed " << seed;
  }
}

TEST(TownPlan, TheDrivenLineAdvancesEvenlyAndTurnsNoSharperThanACar) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const TownPlan plan = make_plan(seed, 600.0);
    for (std::size_t i = 1; i < plan.line.points.size(); ++i) {
      const LinePoint& a = plan.line.points[i - 1];
      const LinePoint& b = plan.line.points[i];
      ASSERT_NEAR((b.position_m - a.position_m).norm(), kLineStepM, 0.002) << seed << " " << i;
      ASSERT_LT(std::abs(b.heading_rad - a.heading_rad), kLineStepM / 7.9) << seed << " " << i;
    }
  }
}

TEST(TownPlan, TheRouteNeverMeetsItself) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const DrivenLine line = make_plan(seed, 800.0).line;
    for (double s = 0.0; s < 800.0; s += 5.0) {
      for (double later = s + 60.0; later < 800.0; later += 5.0) {
        ASSERT_GT((line.at(s).position_m - line.at(later).position_m).norm(), 25.0)
            << "seed " << seed << " at " << s << " and " << later;
      }
    }
  }
}

TEST(TownPlan, GroundIsUnevenByThreeCentimetres) {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (double x = 0.0; x < 2000.0; x += 7.0) {
    for (double y = 0.0; y < 700.0; y += 7.0, ++count) {
      const double height_m = ground_height_m(5, Eigen::Vector2d(x, y));
      sum += height_m;
      squares += height_m * height_m;
    }
  }
  const double mean = sum / count;
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 0.03, 0.004);
  EXPECT_NEAR(mean, 0.0, 0.005);
}

TEST(Footprints, OverlapWhenTheyShareGround) {
  const Footprint square{Eigen::Vector2d(0, 0), 0.0, 1.0, 1.0};
  const Footprint beside{Eigen::Vector2d(2.1, 0), 0.0, 1.0, 1.0};
  // A diamond of half diagonal 1.41: reaches x = 0.69, where the square still is.
  const Footprint diamond{Eigen::Vector2d(2.1, 0), 0.25 * std::numbers::pi, 1.0, 1.0};
  EXPECT_FALSE(overlaps(square, beside));
  EXPECT_TRUE(overlaps(square, diamond));
  EXPECT_TRUE(overlaps(diamond, square));
}

TEST(Buildings, StandNeitherOnStreetsNorInEachOther) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const TownPlan plan = make_plan(seed, 300.0);
    const std::vector<Building> buildings = place_buildings(seed, plan);
    ASSERT_GT(buildings.size(), 20U);
    for (std::size_t i = 0; i < buildings.size(); ++i) {
      for (const Street& street : plan.streets) {
        ASSERT_FALSE(overlaps(buildings[i].footprint, corridor(street)));
      }
      for (std::size_t j = 0; j < i; ++j) {
        ASSERT_FALSE(overlaps(buildings[i].footprint, buildings[j].footprint));
      }
    }
  }
}

TEST(Buildings, ATenthOfTheClutterGoesAndAsMuchComesBetweenDrives) {
  const Town town = town_of(11, 600.0);
  const auto clutter = [&](std::uint64_t drive) {
    const TownMesh mesh = standing_mesh(town, drive);
    std::set<std::array<float, 6>> pieces;  // extent of each triangle
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (mesh.labels[t] != Label::kClutter) continue;
      const Eigen::Vector3f& a = mesh.vertices_m[mesh.triangles[t][0]];
      const Eigen::Vector3f& b = mesh.vertices_m[mesh.triangles[t][2]];
      pieces.insert({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()});
    }
    return pieces;
  };
  const std::set<std::array<float, 6>> before = clutter(0);
  const std::set<std::array<float, 6>> after = clutter(1);
  const auto gone = static_cast<double>(std::count_if(
      before.begin(), before.end(), [&](const auto& piece) { return !after.contains(piece); }));
  const auto fresh = static_cast<double>(std::count_if(
      after.begin(), after.end(), [&](const auto& piece) { return !before.contains(piece); }));
  const auto all = static_cast<double>(before.size());
  EXPECT_NEAR(gone / all, 0.10, 0.04);
  EXPECT_NEAR(fresh / all, 0.10, 0.04);
}

}  // namespace
}  // namespace sightline::town
