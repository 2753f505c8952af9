#include "examples/town/world/ground.h"

#include <cmath>

#include "examples/town/world/mesh.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

double lattice_value(std::uint64_t seed, std::int64_t ix, std::int64_t iy) {
  const std::uint64_t key =
      static_cast<std::uint64_t>(ix) * 0x1f1f1f1f1f1f1f1fULL + static_cast<std::uint64_t>(iy);
  return Random(mix(seed, key)).uniform(-1.0, 1.0);
}

// Value noise between -1 and 1 on a lattice, smooth across its lines.
double lattice_noise(std::uint64_t seed, const Eigen::Vector2d& point_m, double pitch_m) {
  const double x = point_m.x() / pitch_m;
  const double y = point_m.y() / pitch_m;
  const auto ix = static_cast<std::int64_t>(std::floor(x));
  const auto iy = static_cast<std::int64_t>(std::floor(y));
  const double fx = x - std::floor(x);
  const double fy = y - std::floor(y);
  const double u = fx * fx * (3.0 - 2.0 * fx);
  const double v = fy * fy * (3.0 - 2.0 * fy);
  const double low = std::lerp(lattice_value(seed, ix, iy), lattice_value(seed, ix + 1, iy), u);
  const double high =
      std::lerp(lattice_value(seed, ix, iy + 1), lattice_value(seed, ix + 1, iy + 1), u);
  return std::lerp(low, high, v);
}

bool separates(const Eigen::Vector2d& axis, const Footprint& a, const Footprint& b) {
  const auto reach = [&](const Footprint& f) -> double {
    const Eigen::Vector2d along = direction(f.yaw_rad);
    return f.half_length_m * std::abs(axis.dot(along)) +
           f.half_width_m * std::abs(axis.dot(left_of(along)));
  };
  return std::abs(axis.dot(a.centre_m - b.centre_m)) >= reach(a) + reach(b);
}

}  // namespace

bool overlaps(const Footprint& a, const Footprint& b) {
  for (const Footprint* f : {&a, &b}) {
    const Eigen::Vector2d along = direction(f->yaw_rad);
    if (separates(along, a, b) || separates(left_of(along), a, b)) return false;
  }
  return true;
}

bool contains(const Footprint& footprint, const Eigen::Vector2d& point_m) {
  const Eigen::Vector2d along = direction(footprint.yaw_rad);
  const Eigen::Vector2d offset = point_m - footprint.centre_m;
  return std::abs(offset.dot(along)) <= footprint.half_length_m &&
         std::abs(offset.dot(left_of(along))) <= footprint.half_width_m;
}

double ground_height_m(std::uint64_t seed, const Eigen::Vector2d& point_m) {
  // Amplitudes such that both together deviate by 3 cm; a uniform lattice value has 0.58, and
  // smoothing between lattice points takes a quarter of that.
  return 0.044 * lattice_noise(mix(seed, 1), point_m, 5.0) +
         0.054 * lattice_noise(mix(seed, 2), point_m, 23.0);
}

}  // namespace sightline::town
