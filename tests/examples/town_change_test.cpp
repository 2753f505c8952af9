#include "examples/town/world/change.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "examples/town/drive/drive.h"
#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

Town town_with(const TownChange& change) {
  TownOptions options;
  options.seed = 4;
  options.length_m = 300.0;
  options.change = change;
  return value_of(make_town(options));
}

TownChange only(double from_m, double to_m) { return {from_m, to_m, false, false, 0, 1.0}; }

std::vector<LabelledPoint> points_at(const Town& town, double s_m) {
  const DriveSimulator drive =
      value_of(DriveSimulator::make(town, usual_drive(town.options, 0, *town_sensor(16))));
  return drive.scan(static_cast<std::size_t>(s_m)).points;
}

bool has_same_scan(const Town& a, const Town& b, double s_m) {
  const std::vector<LabelledPoint> p = points_at(a, s_m);
  const std::vector<LabelledPoint> q = points_at(b, s_m);
  return std::ranges::equal(p, q, {}, &LabelledPoint::position_m, &LabelledPoint::position_m);
}

TEST(TownChange, LeavesTheTownElsewhereAsItWas) {
  const Town before = town_with({});
  const Town after = town_with({.from_m = 200.0, .to_m = 300.0});
  EXPECT_TRUE(has_same_scan(before, after, 40.0));
  EXPECT_FALSE(has_same_scan(before, after, 250.0));
}

TEST(TownChange, OfEachKindDoesWhatItSays) {
  const Town before = town_with({});
  TownChange rebuilt = only(100.0, 200.0);
  rebuilt.rebuilds = true;
  const Town other_houses = town_with(rebuilt);
  std::size_t other_heights = 0;
  for (std::size_t b = 0; b < before.buildings.size(); ++b) {
    EXPECT_FALSE(other_houses.buildings[b].is_gone);
    other_heights += before.buildings[b].height_m != other_houses.buildings[b].height_m ? 1 : 0;
  }
  EXPECT_GT(other_heights, 3u);
  EXPECT_LT(other_heights, before.buildings.size() / 2);

  TownChange wall = only(100.0, 200.0);
  wall.removes_wall = true;
  const Town no_wall = town_with(wall);
  EXPECT_EQ(std::ranges::count_if(no_wall.buildings, &Building::is_gone), 1);
  EXPECT_LT(no_wall.permanent.triangles.size(), before.permanent.triangles.size());

  TownChange cars = only(100.0, 200.0);
  cars.added_cars = 10;
  const auto car_count = [](const Town& town) {
    return std::ranges::count(standing_mesh(town, 0).labels, Label::kParkedCar);
  };
  EXPECT_GT(car_count(town_with(cars)), car_count(before) + 10 * 12);

  TownChange noise = only(100.0, 200.0);
  noise.noise_factor = 2.0;
  const Town noisy = town_with(noise);
  EXPECT_FALSE(has_same_scan(before, noisy, 150.0));
  EXPECT_TRUE(has_same_scan(before, noisy, 99.0));
  EXPECT_TRUE(has_same_scan(before, noisy, 200.0));
}

TEST(TownChange, ParksNoCarOnTheDrivenLine) {
  const Town town = town_with({.from_m = 0.0, .to_m = 300.0, .added_cars = 60});
  for (const Pose2d& car : added_cars(town.options.change, 1, town.plan)) {
    for (const LinePoint& point : town.plan.line.points) {
      ASSERT_GT((point.position_m - car.position_m).norm(), 1.8);
    }
  }
}

TEST(TownChange, BeyondTheRouteIsRefused) {
  TownOptions options;
  options.length_m = 100.0;
  options.change = {.from_m = 50.0, .to_m = 150.0};
  EXPECT_EQ(code_of(make_town(options)), ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline::town
