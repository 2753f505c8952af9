#include "examples/town/world/mesh.h"

namespace sightline::town {
namespace {

std::uint32_t add_vertex(TownMesh& mesh, const Eigen::Vector3d& vertex_m) {
  mesh.vertices_m.emplace_back(vertex_m.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
}

// The corners of a box at one height, counter-clockwise seen from above.
std::array<Eigen::Vector3d, 4> ring_of(const Box& box, double z_m, double scale) {
  const Eigen::Vector2d along = direction(box.yaw_rad) * (0.5 * box.length_m * scale);
  const Eigen::Vector2d across = left_of(direction(box.yaw_rad)) * (0.5 * box.width_m * scale);
  std::array<Eigen::Vector3d, 4> ring;
  constexpr std::array<std::array<double, 2>, 4> kSigns = {{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d corner = box.centre_m + kSigns[i][0] * along + kSigns[i][1] * across;
    ring[i] = Eigen::Vector3d(corner.x(), corner.y(), z_m);
  }
  return ring;
}

}  // namespace

void add_triangle(TownMesh& mesh, const std::array<Eigen::Vector3d, 3>& corners_m, Label label) {
  const std::uint32_t a = add_vertex(mesh, corners_m[0]);
  const std::uint32_t b = add_vertex(mesh, corners_m[1]);
  const std::uint32_t c = add_vertex(mesh, corners_m[2]);
  mesh.triangles.push_back({a, b, c});
  mesh.labels.push_back(label);
}

void add_quad(TownMesh& mesh, const std::array<Eigen::Vector3d, 4>& corners_m, Label label) {
  const std::uint32_t a = add_vertex(mesh, corners_m[0]);
  const std::uint32_t b = add_vertex(mesh, corners_m[1]);
  const std::uint32_t c = add_vertex(mesh, corners_m[2]);
  const std::uint32_t d = add_vertex(mesh, corners_m[3]);
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
  mesh.labels.insert(mesh.labels.end(), 2, label);
}

void add_box(TownMesh& mesh, const Box& box, Label label, double taper) {
  const std::array<Eigen::Vector3d, 4> low = ring_of(box, box.bottom_m, 1.0);
  const std::array<Eigen::Vector3d, 4> high = ring_of(box, box.top_m, taper);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    add_quad(mesh, {low[i], low[j], high[j], high[i]}, label);
  }
  add_quad(mesh, high, label);
  add_quad(mesh, {low[3], low[2], low[1], low[0]}, label);
}

void add_prism(TownMesh& mesh, const Prism& prism, Label label) {
  const Eigen::Vector3d top(prism.centre_m.x(), prism.centre_m.y(), prism.top_m);
  for (int side = 0; side < prism.sides; ++side) {
    const double turn = 2.0 * std::numbers::pi / prism.sides;
    const Eigen::Vector2d a = prism.centre_m + prism.radius_m * direction(turn * side);
    const Eigen::Vector2d b = prism.centre_m + prism.radius_m * direction(turn * (side + 1));
    const Eigen::Vector3d high_a(a.x(), a.y(), prism.top_m);
    const Eigen::Vector3d high_b(b.x(), b.y(), prism.top_m);
    add_quad(mesh,
             {Eigen::Vector3d(a.x(), a.y(), prism.bottom_m),
              Eigen::Vector3d(b.x(), b.y(), prism.bottom_m), high_b, high_a},
             label);
    add_triangle(mesh, {high_a, high_b, top}, label);
  }
}

void append(TownMesh& mesh, const TownMesh& other) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), other.vertices_m.begin(), other.vertices_m.end());
  for (const std::array<std::uint32_t, 3>& triangle : other.triangles) {
    mesh.triangles.push_back({triangle[0] + offset, triangle[1] + offset, triangle[2] + offset});
  }
  mesh.labels.insert(mesh.labels.end(), other.labels.begin(), other.labels.end());
}

}  // namespace sightline::town
