#include "passes/trajectory/sweep/sweep_times.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

// Beams that fire together point a few degrees apart, and each scan has gaps without a return. So
// the azimuth is followed over blocks of points: the direction of a block is that of the sum of its
// points' directions in the plane.

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kBlock = 256;  // points; a few firings of a dense sensor
constexpr std::size_t kLeastBlocks = 16;
// Share of steps in the other direction: a sweep may be slightly out of order.
constexpr double kMostBackwards = 0.05;
constexpr double kLeastTurn_rad = 300.0 * kPi / 180.0;
constexpr double kMostTurn_rad = 450.0 * kPi / 180.0;

Eigen::Vector2d direction_of(std::span<const Eigen::Vector3d> points_m) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& point_m : points_m) {
    const double length_m = point_m.head<2>().norm();
    if (length_m > 0.0) sum += point_m.head<2>() / length_m;
  }
  return sum;
}

// From the first block to each, counted through full turns.
std::vector<double> turned_rad(std::span<const Eigen::Vector3d> points_m) {
  std::vector<double> turned{0.0};
  Eigen::Vector2d before = direction_of(points_m.first(kBlock));
  for (std::size_t begin = kBlock; begin + kBlock <= points_m.size(); begin += kBlock) {
    const Eigen::Vector2d now = direction_of(points_m.subspan(begin, kBlock));
    const double step_rad =
        portable_atan2(before.x() * now.y() - before.y() * now.x(), before.dot(now));
    turned.push_back(turned.back() + step_rad);
    before = now;
  }
  return turned;
}

bool is_sweep(std::span<const double> turned) {
  const double whole_rad = turned.back();
  if (std::abs(whole_rad) < kLeastTurn_rad || std::abs(whole_rad) > kMostTurn_rad) return false;
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < turned.size(); ++i) {
    backwards += (turned[i] - turned[i - 1]) * whole_rad < 0.0 ? 1 : 0;
  }
  return static_cast<double>(backwards) <= kMostBackwards * static_cast<double>(turned.size());
}

}  // namespace

std::vector<double> sweep_times(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < kLeastBlocks * kBlock) return {};
  const std::vector<double> turned = turned_rad(points_m);
  if (!is_sweep(turned)) return {};
  std::vector<double> times(points_m.size());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    // The azimuth of a block is that of its middle.
    const double at = std::clamp((static_cast<double>(i) - 0.5 * kBlock) / kBlock, 0.0,
                                 static_cast<double>(turned.size() - 1));
    const std::size_t block = std::min(static_cast<std::size_t>(at), turned.size() - 2);
    const double within = at - static_cast<double>(block);
    const double angle_rad = turned[block] + within * (turned[block + 1] - turned[block]);
    times[i] = std::clamp(angle_rad / turned.back(), 0.0, 1.0);
  }
  return times;
}

}  // namespace sightline
