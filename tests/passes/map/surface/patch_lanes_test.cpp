#include "passes/map/surface/patch_lanes.h"

#include <gtest/gtest.h>
#include <cmath>

#include "formats/base/random.h"

namespace sightline {
namespace {

Eigen::Vector3d random_vector(Random& random, double most) {
  return {random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most)};
}

// Around a place far from the origin of the map.
const Eigen::Vector3d kPlace_m(4000.0, -7000.0, 90.0);

std::vector<PatchPlane> random_planes(Random& random, int count) {
  std::vector<PatchPlane> planes;
  for (int i = 0; i < count; ++i) {
    SurfacePatch patch;
    patch.centre_m = kPlace_m + random_vector(random, 100.0);
    patch.normal = random_vector(random, 1.0).normalized();
    if (patch.normal.z() < 0.0) patch.normal = -patch.normal;
    patch.half_side_m = i % 2 == 0 ? 0.36 : 3.6;
    planes.emplace_back(patch);
  }
  return planes;
}

Eigen::AlignedBox3d box_m() {
  return {kPlace_m - Eigen::Vector3d::Constant(110.0), kPlace_m + Eigen::Vector3d::Constant(110.0)};
}

// Over a patch, in units of its halves.
Eigen::Vector3d at(const PatchPlane& plane, double along, double across, double off) {
  return plane.centre_m +
         plane.half_side_m * (along * plane.side + across * plane.other_side + off * plane.normal);
}

std::int32_t square_in_float(const PatchLanes& lanes, std::uint32_t patch,
                             const Eigen::Vector3d& place_m) {
  PatchLanes::Places places;
  places.add(lanes.place_of(place_m));
  return lanes.patch(patch).squares_of(places, 0)[0];
}

TEST(PatchLanes, TellsTheSquareOfAReturnWhereFloatsTellIt) {
  Random random(1);
  const std::vector<PatchPlane> planes = random_planes(random, 200);
  const PatchLanes lanes(planes, box_m());
  int inside = 0;
  int unsure = 0;
  for (std::uint32_t i = 0; i < planes.size(); ++i) {
    PatchLanes::Places places;
    std::vector<Eigen::Vector3d> places_m;
    for (int j = 0; j < 250; ++j) {
      places_m.push_back(at(planes[i], random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2),
                            random.uniform(-0.5, 0.5)));
      places.add(lanes.place_of(places_m.back()));
    }
    for (std::size_t j = 0; j < places_m.size(); ++j) {
      const std::int32_t square =
          lanes.patch(i).squares_of(places, j - j % PatchLanes::kAtOnce)[j % PatchLanes::kAtOnce];
      inside += square >= 0 ? 1 : 0;
      unsure += square == PatchLanes::kUnsure ? 1 : 0;
      if (square == PatchLanes::kUnsure) continue;
      EXPECT_EQ(square, planes[i].square_of_return(places_m[j]));
    }
  }
  EXPECT_GT(inside, 15000);
  EXPECT_LT(unsure, 1500);  // 3 %
}

TEST(PatchLanes, AreNotSureBesideTheEdgesOfSquaresAndOfTheRoomForReturns) {
  Random random(2);
  const std::vector<PatchPlane> planes = random_planes(random, 500);
  const PatchLanes lanes(planes, box_m());
  for (std::uint32_t i = 0; i < planes.size(); ++i) {
    const double tiny = random.uniform(-1e-6, 1e-6);
    const double edge = 0.25 * (i % 9) - 1.0 + tiny;
    for (const Eigen::Vector3d& place_m :
         {at(planes[i], edge, 0.1, 0.0), at(planes[i], 0.1, edge, 0.0),
          at(planes[i], 0.1, 0.1, kMostOffPlane + tiny)}) {
      const std::int32_t square = square_in_float(lanes, i, place_m);
      if (square == PatchLanes::kUnsure) continue;
      EXPECT_EQ(square, planes[i].square_of_return(place_m));
    }
  }
}

TEST(PatchLanes, DenyNoRayThatCrossesAndMostOthers) {
  Random random(3);
  const std::vector<PatchPlane> planes = random_planes(random, 2000);
  const PatchLanes lanes(planes, box_m());
  int crossing = 0;
  int others = 0;
  int denied = 0;
  for (std::uint32_t i = 0; i < planes.size(); ++i) {
    const PatchPlane& plane = planes[i];
    const Eigen::Vector3d through_m =
        at(plane, random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2), 0.0);
    const Eigen::Vector3d direction = random_vector(random, 1.0).normalized();
    const Eigen::Vector3d from_m = through_m - random.uniform(0.0, 60.0) * direction;
    const double slope = plane.normal.dot(direction);
    if (std::abs(slope) < kLeastSlope) continue;
    const double distance_m = plane.normal.dot(plane.centre_m - from_m) / slope;
    // Both ends of the stretch lie at the crossing as often as not.
    const double enter_m = distance_m + (i % 2 == 0 ? 0.0 : random.uniform(-0.5, 0.5));
    const double leave_m = enter_m + (i % 3 == 0 ? 0.0 : random.uniform(0.0, 0.5));
    const PatchLanes::Ray ray = lanes.ray_of(from_m, direction, 60.0);
    const bool crosses = plane.square_of(from_m + distance_m * direction) >= 0 &&
                         distance_m >= enter_m && distance_m <= leave_m;
    const bool may = lanes.patch(i).may_cross(ray, static_cast<float>(enter_m - ray.slack_m),
                                              static_cast<float>(leave_m + ray.slack_m));
    if (crosses) {
      ++crossing;
      EXPECT_TRUE(may);
    } else {
      ++others;
      denied += may ? 0 : 1;
    }
  }
  EXPECT_GT(crossing, 300);
  EXPECT_GT(denied, others * 9 / 10);
}

}  // namespace
}  // namespace sightline
