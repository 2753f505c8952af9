#include "passes/map/places/free_heading.h"

#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr int kWays = 16;              // of half a turn
constexpr double kLookAlong_m = 20.0;  // each way

// How far free ground goes on that way, in steps of the raster.
int steps_ahead(const FreeGround& free, std::uint32_t place, const Eigen::Vector2d& way, int most) {
  const GroundPlace begin = free.places()[place];
  for (int step = 1; step <= most; ++step) {
    const std::int32_t x = begin.x + static_cast<std::int32_t>(std::lround(step * way.x()));
    const std::int32_t y = begin.y + static_cast<std::int32_t>(std::lround(step * way.y()));
    place = free.next(free.places()[place], x, y);
    if (place == FreeGround::kNone) return step - 1;
  }
  return most;
}

std::array<Eigen::Vector2d, kWays> ways() {
  std::array<Eigen::Vector2d, kWays> all;
  for (int i = 0; i < kWays; ++i) {
    const SinCos turned = portable_sin_cos(i * std::numbers::pi / kWays);
    all[static_cast<std::size_t>(i)] = {turned.cos, turned.sin};
  }
  return all;
}

}  // namespace

Eigen::Vector2d free_heading(const FreeGround& free, std::uint32_t place) {
  static const std::array<Eigen::Vector2d, kWays> kAll = ways();
  const auto most = static_cast<int>(kLookAlong_m / free.step_m());
  int longest = -1;
  Eigen::Vector2d heading = kAll.front();
  for (const Eigen::Vector2d& way : kAll) {
    const int length = steps_ahead(free, place, way, most) + steps_ahead(free, place, -way, most);
    if (length <= longest) continue;
    longest = length;
    heading = way;
  }
  return heading;
}

}  // namespace sightline
