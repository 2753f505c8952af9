#include "tests/support/lane/mesh.h"

#include <cmath>
#include <numbers>

namespace sightline::lane {
namespace {

Eigen::Vector3d placed(const Block& block, const Eigen::Vector3d& from_centre_m) {
  const double c = std::cos(block.yaw_rad);
  const double s = std::sin(block.yaw_rad);
  return block.centre_m + Eigen::Vector3d(c * from_centre_m.x() - s * from_centre_m.y(),
                                          s * from_centre_m.x() + c * from_centre_m.y(),
                                          from_centre_m.z());
}

double signed_power(double value, double exponent) {
  return std::copysign(std::pow(std::abs(value), exponent), value);
}

}  // namespace

void add_triangle(Mesh& mesh, const std::array<Eigen::Vector3d, 3>& corners_m, Kind kind) {
  mesh.triangles_m.push_back(corners_m);
  mesh.kinds.push_back(kind);
}

void add_quad(Mesh& mesh, const Quad& corners_m, Kind kind) {
  add_triangle(mesh, {corners_m[0], corners_m[1], corners_m[2]}, kind);
  add_triangle(mesh, {corners_m[0], corners_m[2], corners_m[3]}, kind);
}

void add_block(Mesh& mesh, const Block& block, Kind kind) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      Quad corners_m;
      for (std::size_t i = 0; i < 4; ++i) {
        Eigen::Vector3d corner = Eigen::Vector3d::Zero();
        corner[axis] = side;
        corner[u] = i == 1 || i == 2 ? 1.0 : -1.0;
        corner[v] = i >= 2 ? 1.0 : -1.0;
        corners_m[i] = placed(block, corner.cwiseProduct(block.half_m));
      }
      add_quad(mesh, corners_m, kind);
    }
  }
}

void add_tube(Mesh& mesh, const Tube& tube, Kind kind) {
  constexpr int kSides = 6;
  const Eigen::Vector3d along = (tube.to_m - tube.from_m).normalized();
  const Eigen::Vector3d u_m = tube.radius_m * along.unitOrthogonal();
  const Eigen::Vector3d v_m = along.cross(u_m);
  for (int i = 0; i < kSides; ++i) {
    const double a = 2.0 * std::numbers::pi * i / kSides;
    const double b = 2.0 * std::numbers::pi * (i + 1) / kSides;
    const Eigen::Vector3d at_a_m = std::cos(a) * u_m + std::sin(a) * v_m;
    const Eigen::Vector3d at_b_m = std::cos(b) * u_m + std::sin(b) * v_m;
    add_quad(mesh,
             {tube.from_m + at_a_m, tube.from_m + at_b_m, tube.to_m + at_b_m, tube.to_m + at_a_m},
             kind);
  }
}

void add_rounded(Mesh& mesh, const Block& block, double roundness, Kind kind) {
  constexpr int kAround = 32;
  constexpr int kUp = 16;
  const auto at = [&](int i, int j) -> Eigen::Vector3d {
    const double azimuth = 2.0 * std::numbers::pi * i / kAround;
    const double elevation = std::numbers::pi * (1.0 * j / kUp - 0.5);
    const double level = signed_power(std::cos(elevation), roundness);
    const Eigen::Vector3d unit(level * signed_power(std::cos(azimuth), roundness),
                               level * signed_power(std::sin(azimuth), roundness),
                               signed_power(std::sin(elevation), roundness));
    return placed(block, unit.cwiseProduct(block.half_m));
  };
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kUp; ++j) {
      add_quad(mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}, kind);
    }
  }
}

}  // namespace sightline::lane
