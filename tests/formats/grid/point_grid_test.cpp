#include "formats/grid/point_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "formats/base/random.h"

namespace sightline {
namespace {

using Points = std::vector<Eigen::Vector3d>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<NearPoint> asked_of_all(const Points& points_m, const Eigen::Vector3d& p_m,
                                    double reach_m) {
  std::vector<NearPoint> found;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const double distance_m = (points_m[i] - p_m).norm();
    if (points_m[i].allFinite() && distance_m <= reach_m) found.push_back({distance_m, i});
  }
  std::ranges::sort(found);
  return found;
}

std::optional<NearPoint> first_of(const std::vector<NearPoint>& found) {
  return found.empty() ? std::nullopt : std::optional(found.front());
}

// At random, on a face of a cell, the next number beside one, or where another point lies.
Eigen::Vector3d random_place(Random& random, const Points& others_m, double scale_m) {
  const auto coordinate_m = [&] {
    const double at_m = random.uniform(-scale_m, scale_m);
    switch (random.below(4)) {
      case 0:
        return std::round(at_m);
      case 1:
        return std::nextafter(std::round(at_m), random.below(2) == 0 ? -1e300 : 1e300);
      default:
        return at_m;
    }
  };
  if (!others_m.empty() && random.below(5) == 0) return others_m[random.below(others_m.size())];
  return {coordinate_m(), coordinate_m(), coordinate_m()};
}

TEST(PointGrid, FindsTheNearestAndTheLowerOfTwoEquallyNear) {
  const PointGrid grid(Points{{9.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, {-3.0, 0.0, 0.0}});
  EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, 5.0), (NearPoint{3.0, 1}));
  EXPECT_EQ(grid.nearest({-0.5, 0.0, 0.0}, 5.0), (NearPoint{2.5, 2}));
  EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, 3.0), (NearPoint{3.0, 1})) << "the reach is inside";
  EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, 2.9), std::nullopt);
  EXPECT_EQ(grid.nearest({0.0, 0.0, 4.0}, 5.0), (NearPoint{5.0, 1})) << "heights count";
  const std::vector<NearPoint> all = {{3.0, 1}, {3.0, 2}, {9.0, 0}};
  EXPECT_EQ(grid.within({0.0, 0.0, 0.0}, 9.0), all);
}

TEST(PointGrid, AnswersAsAskingEveryPointWould) {
  Random random(1);
  for (int world = 0; world < 60; ++world) {
    const double scale_m = std::pow(10.0, random.uniform(0.0, 4.0));
    Points points_m;
    const std::size_t count = random.below(150);
    while (points_m.size() < count) points_m.push_back(random_place(random, points_m, scale_m));
    const PointGrid grid(points_m, world % 3 == 0 ? 1.0 : random.uniform(0.01, scale_m));
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d p_m = random_place(random, points_m, 1.2 * scale_m);
      const double reach_m = random.below(4) == 0 ? std::round(random.uniform(0.0, scale_m))
                                                  : scale_m * std::pow(random.uniform(), 3.0);
      const std::vector<NearPoint> expected = asked_of_all(points_m, p_m, reach_m);
      ASSERT_EQ(grid.within(p_m, reach_m), expected);
      ASSERT_EQ(grid.nearest(p_m, reach_m), first_of(expected));
      ASSERT_EQ(grid.nearest(p_m, kInfinity), first_of(asked_of_all(points_m, p_m, kInfinity)));
    }
  }
}

TEST(PointGrid, FindsTheNearestThatIsAccepted) {
  Random random(2);
  Points points_m;
  for (int i = 0; i < 300; ++i) points_m.push_back(random_place(random, points_m, 40.0));
  const PointGrid grid(points_m);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p_m = random_place(random, points_m, 60.0);
    const std::size_t least = random.below(400);
    const auto is_late = [&](const NearPoint& point) { return point.index >= least; };
    std::vector<NearPoint> expected = asked_of_all(points_m, p_m, 50.0);
    std::erase_if(expected, [&](const NearPoint& point) { return !is_late(point); });
    ASSERT_EQ(grid.nearest(p_m, 50.0, is_late), first_of(expected));
  }
}

TEST(PointGrid, FindsTheNearestOnALevel) {
  const PointGrid grid(Points{{0.0, 0.0, 1.8}, {2.0, 0.0, 4.55}, {2.0, 0.0, 7.3}});
  EXPECT_EQ(grid.nearest_on_level({2.0, 0.0, 4.0}, 5.0)->index, 1U);
  EXPECT_EQ(grid.nearest_on_level({0.0, 0.0, 4.55}, 5.0), (NearPoint{2.0, 1})) << "2.75 m above 0";
  EXPECT_EQ(grid.nearest_on_level({0.0, 0.0, 3.0}, 5.0), std::nullopt) << "between two";
  EXPECT_EQ(grid.nearest_on_level({0.0, 0.0, 4.55}, 1.9), std::nullopt) << "the reach";
}

TEST(PointGrid, VisitsThePointsOverABoxFacesIncluded) {
  Random random(3);
  Points points_m;
  for (int i = 0; i < 500; ++i) points_m.push_back(random_place(random, points_m, 30.0));
  const PointGrid grid(points_m, 2.0);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d low_m = random_place(random, points_m, 40.0).head<2>();
    const Eigen::Vector2d wide_m(random.uniform(-1.0, 30.0), random.uniform(-1.0, 30.0));
    const Eigen::AlignedBox2d box_m(low_m, low_m + wide_m);
    std::vector<std::size_t> expected;
    for (std::size_t k = 0; k < points_m.size(); ++k) {
      if (box_m.contains(points_m[k].head<2>())) expected.push_back(k);
    }
    std::vector<std::size_t> found;
    grid.visit_over(box_m, [&](std::size_t k) { found.push_back(k); });
    std::ranges::sort(found);
    ASSERT_EQ(found, expected);
  }
}

TEST(PointGrid, OfNoPointsFindsNone) {
  for (const PointGrid& grid : {PointGrid(), PointGrid(Points{})}) {
    EXPECT_EQ(grid.size(), 0U);
    EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, kInfinity), std::nullopt);
    EXPECT_TRUE(grid.within({0.0, 0.0, 0.0}, kInfinity).empty());
  }
}

// A column of cells a metre wide between them would be 10 million long.
TEST(PointGrid, AnswersFromTenThousandKilometresAwayAndFarther) {
  const Points points_m = {{0.0, 0.0, 0.0}, {1e7, 0.0, 0.0}, {1e7, 1.0, 0.0}, {-1e300, 0.0, 0.0}};
  const PointGrid grid(points_m, 1.0);
  EXPECT_EQ(grid.nearest({1e7, 1e7, 0.0}, 1e6), std::nullopt);
  EXPECT_EQ(grid.nearest({1e7, 1e7, 0.0}, kInfinity), (NearPoint{1e7 - 1.0, 2}));
  EXPECT_EQ(grid.nearest({-1e300, 0.0, 0.0}, 1.0), (NearPoint{0.0, 3}));
  EXPECT_EQ(grid.nearest({1e12, 1e12, 0.0}, 1.0), std::nullopt);
  EXPECT_EQ(grid.within({1e7, 0.5, 0.0}, 2e7), asked_of_all(points_m, {1e7, 0.5, 0.0}, 2e7));
}

TEST(PointGrid, NeverFindsWhatIsNotFiniteAndNothingIsNearWhatIsNotFinite) {
  const PointGrid grid(Points{{kNan, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, kInfinity, 0.0}});
  EXPECT_EQ(grid.size(), 1U);
  EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, kInfinity), (NearPoint{1.0, 1}));
  EXPECT_EQ(grid.nearest({0.0, 0.0, kNan}, kInfinity), std::nullopt);
  EXPECT_EQ(grid.nearest({0.0, kInfinity, 0.0}, kInfinity), std::nullopt);
  EXPECT_EQ(grid.nearest({0.0, 0.0, 0.0}, kNan), std::nullopt);
  EXPECT_EQ(grid.nearest({1.0, 0.0, 0.0}, -1.0), std::nullopt);
  EXPECT_TRUE(grid.within({kNan, 0.0, 0.0}, 1.0).empty());
  std::size_t visited = 0;
  grid.visit_over(Eigen::AlignedBox2d(Eigen::Vector2d(kNan, 0.0), Eigen::Vector2d(1.0, 1.0)),
                  [&](std::size_t) { ++visited; });
  EXPECT_EQ(visited, 0U);
}

// The position of a pose is part of a matrix; asked as a vector it must give the same bits.
TEST(PointGrid, MeasuresAsPosesDo) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    Eigen::Isometry3d a = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d b = Eigen::Isometry3d::Identity();
    a.translation() = random_place(random, {}, 1e4);
    b.translation() = a.translation() + random_place(random, {}, 10.0);
    const double distance_m = (a.translation() - b.translation()).norm();
    ASSERT_EQ(PointGrid(Points{a.translation()}).nearest(b.translation(), kInfinity),
              (NearPoint{distance_m, 0}));
    const Eigen::Vector3d in_plane_m(a.translation().x(), a.translation().y(), 0.0);
    const Eigen::Vector3d other_m(b.translation().x(), b.translation().y(), 0.0);
    const Eigen::Vector3d off_m = a.translation() - b.translation();
    ASSERT_EQ((in_plane_m - other_m).norm(), off_m.head<2>().norm());
  }
}

}  // namespace
}  // namespace sightline
