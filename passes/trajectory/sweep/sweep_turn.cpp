#include "passes/trajectory/sweep/sweep_turn.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kLeastPoints = 4096;
// Scans in order of time turn once or twice; sensors have more rings.
constexpr double kLeastRings = 8.0;
// Share of steps in the other direction, by noise near the axis.
constexpr double kMostBackwards = 0.05;
// Beginnings nearer to each other count as one.
constexpr double kOneBeginning_rad = 10.0 * kPi / 180.0;

double azimuth_rad(const Eigen::Vector3d& point_m) {
  return portable_atan2(point_m.y(), point_m.x());
}

// To within half a turn of 0.
double wrapped(double angle_rad) {
  return angle_rad - 2.0 * kPi * std::round(angle_rad / (2.0 * kPi));
}

}  // namespace

std::vector<SweepTurn> turns_of_rings(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < kLeastPoints) return {};
  double turned_rad = 0.0;
  std::size_t left = 0;
  std::size_t right = 0;
  double before_rad = azimuth_rad(points_m.front());
  for (const Eigen::Vector3d& point_m : points_m.subspan(1)) {
    const double now_rad = azimuth_rad(point_m);
    const double step_rad = wrapped(now_rad - before_rad);
    before_rad = now_rad;
    turned_rad += step_rad;
    left += step_rad > 0.0 ? 1 : 0;
    right += step_rad < 0.0 ? 1 : 0;
  }
  if (std::abs(turned_rad) < kLeastRings * 2.0 * kPi) return {};
  const auto most = kMostBackwards * static_cast<double>(points_m.size());
  if (static_cast<double>(std::min(left, right)) > most) return {};
  const SweepTurn as_stored{azimuth_rad(points_m.front()), turned_rad < 0.0};
  std::vector<SweepTurn> turns{{kPi, true}, {kPi, false}};
  const bool begins_behind = std::abs(wrapped(as_stored.begin_rad - kPi)) < kOneBeginning_rad;
  if (!begins_behind) turns.push_back(as_stored);
  return turns;
}

std::vector<double> turn_times(std::span<const Eigen::Vector3d> points_m, const SweepTurn& turn) {
  std::vector<double> times;
  times.reserve(points_m.size());
  for (const Eigen::Vector3d& point_m : points_m) {
    const double left_rad = azimuth_rad(point_m) - turn.begin_rad;
    const double turns = (turn.is_clockwise ? -left_rad : left_rad) / (2.0 * kPi);
    times.push_back(turns - std::floor(turns));
  }
  return times;
}

}  // namespace sightline
