#include "passes/trajectory/sweep/turn_trial.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/text/table.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "passes/trajectory/local/stretch_of_drive.h"
#include "passes/trajectory/sweep/turn_clock.h"
#include "passes/trajectory/sweep/turn_curve.h"
#include "passes/trajectory/sweep/undistorted.h"

namespace sightline {
namespace {

constexpr std::size_t kTrialScans = 60;
constexpr std::int64_t kLongestInterval_ns = 1'500'000'000;
// A turn that moves what is 50 m away by less than half a centimetre.
constexpr double kLeastBend_rad = 1e-4;
// A clock is known to this from poses ten times a second.
constexpr std::int64_t kLeastAhead_ns = 10'000'000;
// Another clock must explain so much of the turning that the old one does not.
constexpr double kLeastShareExplained = 0.2;
// Right rates gain 0.02 nat and more where poses are off by 1 cm and 0.05 degrees, and wrong ones
// lose 0.05.
constexpr double kSharper_nat = 0.005;

// Of each scan of the first sensor: how far the rates bend the turning to its next one from an even
// one. Of scans of other sensors 0.
std::vector<double> bends_rad(const Drive& drive, const Trajectory& trajectory) {
  std::vector<double> bends(trajectory.poses.size(), 0.0);
  const TrajectoryPose* from = nullptr;
  std::size_t of_scan = 0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    if (drive.scans[i].sensor_index != 0) continue;
    const TrajectoryPose& to = trajectory.poses[i];
    const bool is_step =
        from && from->piece == to.piece && to.stamp_ns - from->stamp_ns <= kLongestInterval_ns;
    if (is_step) {
      const std::optional<TurnCurve> curve = TurnCurve::between(
          drive.turn_rates,
          {from->stamp_ns, to.stamp_ns, from->T_map_vehicle.linear(), to.T_map_vehicle.linear()});
      if (curve) bends[of_scan] = curve->bend_rad();
    }
    from = &to;
    of_scan = i;
  }
  return bends;
}

struct Stretch {
  std::size_t first = 0;
  std::size_t count = 0;
  double bend_rad = 0.0;  // mean
};

// The scans in a row that bend most.
Stretch most_bent(const std::vector<double>& bends) {
  Stretch most;
  for (std::size_t end = 1; end <= bends.size(); ++end) {
    const std::size_t first = end > kTrialScans ? end - kTrialScans : 0;
    double sum_rad = 0.0;
    for (std::size_t i = first; i < end; ++i) sum_rad += bends[i];
    const double mean_rad = sum_rad / static_cast<double>(kTrialScans);
    if (mean_rad > most.bend_rad) most = {first, end - first, mean_rad};
  }
  return most;
}

Result<double> entropy_nat(PassContext& ctx, const Drive& drive, const Trajectory& trajectory,
                           const Stretch& stretch) {
  const Drive straight = stretch_of(undistorted(drive, trajectory), stretch.first, stretch.count);
  const Trajectory part = stretch_of(trajectory, stretch.first, stretch.count);
  SIGHTLINE_ASSIGN(const Sharpness sharpness, measure_sharpness(ctx, {}, straight, part));
  return sharpness.of_map.mean_entropy_nat;
}

// How far the clock is ahead; 0 where another one does not explain clearly more.
std::int64_t ahead_ns(const TurnClock& clock) {
  const double unexplained = 1.0 - clock.explained_as_is;
  const bool is_clear =
      clock.explained_moved - clock.explained_as_is > kLeastShareExplained * unexplained;
  const bool is_far = std::abs(clock.ahead_ns) >= kLeastAhead_ns;
  return clock.is_known && is_clear && is_far && clock.explained_moved > 0.5 ? clock.ahead_ns : 0;
}

std::string thousandths(double value) { return format_double(std::round(value * 1e3) / 1e3); }

}  // namespace

Drive without_turns(Drive drive) {
  drive.turn_rates.clear();
  return drive;
}

Result<Drive> with_imu_if_sharper(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory) {
  if (drive.turn_rates.empty()) return drive;
  const std::string name = "drive " + drive.name + ": ";
  Drive turned = drive;
  const TurnClock clock = turn_clock(poses_of_first_sensor(drive, trajectory), drive.turn_rates);
  const std::int64_t moved_ns = ahead_ns(clock);
  if (moved_ns != 0) {
    turned.turn_rates = moved_by(drive.turn_rates, moved_ns);
    ctx.warn(name + "the clock of the turn rates is " +
             thousandths(1e-9 * static_cast<double>(std::abs(moved_ns))) + " s " +
             (moved_ns > 0 ? "ahead of" : "behind") +
             " that of the scans, by the turning of the poses; the rates are moved");
  }
  const Stretch stretch = most_bent(bends_rad(turned, trajectory));
  if (stretch.bend_rad < kLeastBend_rad) {
    ctx.warn(name + "turn rates are not used: they cover no scans, or the vehicle turned evenly");
    return without_turns(drive);
  }
  const Drive even = without_turns(drive);
  SIGHTLINE_ASSIGN(const double even_nat, entropy_nat(ctx, even, trajectory, stretch));
  SIGHTLINE_ASSIGN(const double turned_nat, entropy_nat(ctx, turned, trajectory, stretch));
  const bool is_sharper = turned_nat < even_nat - kSharper_nat;
  ctx.warn(name + "turn rates are " + (is_sharper ? "used" : "not used") +
           ": where they change most, scans lie at an entropy of " + thousandths(turned_nat) +
           " nat with them and of " + thousandths(even_nat) + " nat without");
  return is_sharper ? turned : even;
}

}  // namespace sightline
