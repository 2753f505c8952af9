#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "examples/town/world/hard/place.h"
#include "examples/town/world/mesh.h"
#include "examples/town/world/plan.h"
#include "formats/base/random.h"

// Coordinates of the road of a hard world: arc length s of the driven line, lateral to the left of
// it, and up from its height; m.

namespace sightline::town {

// The inside of a car park: a loop of two straights, joined by half circles, that is driven `loops`
// times. Its second straight is a ramp to the next storey.
struct CarPark {
  static constexpr double kStorey_m = 2.75;    // from floor to floor
  static constexpr double kRadius_m = 6.0;     // of the half circles
  static constexpr double kApproach_m = 10.0;  // from a face of the building to the loop
  int loops = 0;                               // storeys that are driven less one
  double straight_m = 20.0;

  [[nodiscard]] double depth_m() const { return 2.0 * kApproach_m + straight_m; }
  // Where ramp `i` begins, after entering the building.
  [[nodiscard]] double ramp_from_m(int i) const;
};
CarPark car_park_of(const Place& place);

// The driven line of a hard world with its heights; the worlds begin at the origin, heading +x.
DrivenLine make_road_line(std::uint64_t seed, const std::vector<Place>& places);

struct RoadPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double heading_rad = 0.0;
  double slope = 0.0;  // rise for each metre of arc length
};

// A view of a world's line; positions are continuous with their first derivatives in s.
struct Road {
  std::uint64_t seed = 0;  // of the world
  const DrivenLine& line;
  const std::vector<Place>& places;

  [[nodiscard]] RoadPoint at(double s_m) const;
  [[nodiscard]] Eigen::Vector3d on(double s_m, double lateral_m, double up_m) const;
  // The uneven ground above the line's height: none on made roads, 3 cm deviation in a town.
  [[nodiscard]] double ground_m(double s_m, double lateral_m) const;
};

struct Stretch {
  double from_m = 0.0;
  double to_m = 0.0;
};

// Worlds of even seeds have roads without details: no lamps, posts or pillars, so that nothing
// constrains them along the road where no end is in sight. Those of odd seeds have them.
inline bool is_smooth(std::uint64_t seed) { return seed % 2 == 0; }

// A profile across the road, as pairs of lateral and up, that is drawn along a stretch of it.
using Profile = std::vector<std::pair<double, double>>;
void extrude(TownMesh& mesh, const Road& road, const Stretch& stretch, const Profile& profile,
             Label label);

// A closed bar along the road: `profile` is its outline.
void extrude_bar(TownMesh& mesh, const Road& road, const Stretch& stretch, Profile profile,
                 Label label);

// An upright box whose length lies along the road, and a pole.
struct Placement {
  double s_m = 0.0;
  double lateral_m = 0.0;
};
struct BoxSize {
  double length_m = 1.0;
  double width_m = 1.0;
  double bottom_m = 0.0;  // above the line's height
  double top_m = 1.0;
};
void add_road_box(TownMesh& mesh, const Road& road, const Placement& at, const BoxSize& size,
                  Label label);
void add_road_pole(TownMesh& mesh, const Road& road, const Placement& at, double radius_m,
                   double top_m, Label label = Label::kPole);

// Arc lengths in a stretch at an exact pitch.
std::vector<double> evenly(const Stretch& stretch, double pitch_m);

}  // namespace sightline::town
