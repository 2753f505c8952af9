#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

// The exact geometry of a lane: triangles, each with what it belongs to. Metres, z up; the lane
// leads along +y. Nothing here is shared with examples/town: what is tuned to one generator shows
// its faults in the other.

namespace sightline::lane {

enum class Kind : std::uint8_t {
  kGround,
  kWall,
  kWindow,  // a pane set back in the wall
  kRoof,
  kArch,  // the sides and the vault of a passage
  kFence,
  kHedge,
  kCrown,
  kTrunk,  // and branches
  kPole,
  kSign,
  kCar,
};
inline constexpr std::size_t kKinds = 12;
inline constexpr std::array<std::string_view, kKinds> kKindNames = {
    "ground", "wall",  "window", "roof", "arch", "fence",
    "hedge",  "crown", "trunk",  "pole", "sign", "car"};

inline bool is_foliage(Kind kind) { return kind == Kind::kHedge || kind == Kind::kCrown; }

struct Mesh {
  std::vector<std::array<Eigen::Vector3d, 3>> triangles_m;
  std::vector<Kind> kinds;  // one a triangle
};

using Quad = std::array<Eigen::Vector3d, 4>;  // corners in order

void add_triangle(Mesh& mesh, const std::array<Eigen::Vector3d, 3>& corners_m, Kind kind);
void add_quad(Mesh& mesh, const Quad& corners_m, Kind kind);

// All six faces, turned by yaw_rad about the vertical through the centre.
struct Block {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_m = Eigen::Vector3d::Ones();
  double yaw_rad = 0.0;
};
void add_block(Mesh& mesh, const Block& block, Kind kind);

// A tube of six sides from one end to the other, open at both.
struct Tube {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::UnitZ();
  double radius_m = 0.1;
};
void add_tube(Mesh& mesh, const Tube& tube, Kind kind);

// A rounded body: |x/a|^(2/e) + |y/b|^(2/e) + |z/c|^(2/e) = 1 for e = roundness: 1 is an ellipsoid,
// near 0 a box. Turned like a block.
void add_rounded(Mesh& mesh, const Block& block, double roundness, Kind kind);

}  // namespace sightline::lane
