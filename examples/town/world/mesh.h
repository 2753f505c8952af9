#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "formats/base/portable_math.h"

// The exact geometry of a town: triangles, each with what it belongs to. Town coordinates: metres,
// z up, the driven line begins at the origin.

namespace sightline::town {

enum class Label : std::uint8_t {
  kGround,
  kKerb,  // and the pavement behind it
  kFacade,
  kWindow,
  kClutter,  // balconies, ledges, signs, planters
  kTrunk,
  kCrown,
  kPole,
  kParkedCar,
  kMovingCar,
  kPedestrian,
  kFog,
};

// Things that move during a drive; everything else stands still as long as it lasts.
inline bool is_moving(Label label) {
  return label == Label::kMovingCar || label == Label::kPedestrian || label == Label::kFog;
}

// Vertices are float because that is what the ray caster holds: no ray meets other numbers.
struct TownMesh {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Label> labels;  // one a triangle
};

// An upright box on a base: `yaw_rad` turns +x to its length.
struct Box {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
  double length_m = 1.0;
  double width_m = 1.0;
  double bottom_m = 0.0;
  double top_m = 1.0;
};

// Planar and convex, corners in order.
void add_quad(TownMesh& mesh, const std::array<Eigen::Vector3d, 4>& corners_m, Label label);
void add_triangle(TownMesh& mesh, const std::array<Eigen::Vector3d, 3>& corners_m, Label label);

// All six faces. `taper` shrinks length and width of the top: 1 is a plain box.
void add_box(TownMesh& mesh, const Box& box, Label label, double taper = 1.0);

// An upright prism over a regular polygon, closed above.
struct Prism {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0.1;
  double bottom_m = 0.0;
  double top_m = 1.0;
  int sides = 8;
};
void add_prism(TownMesh& mesh, const Prism& prism, Label label);

void append(TownMesh& mesh, const TownMesh& other);

inline double to_radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

inline Eigen::Vector2d direction(double yaw_rad) {
  const SinCos yaw = portable_sin_cos(yaw_rad);
  return Eigen::Vector2d(yaw.cos, yaw.sin);
}
inline Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return Eigen::Vector2d(-v.y(), v.x()); }

}  // namespace sightline::town
