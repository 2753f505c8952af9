#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// Whether any scan has times of its points.
bool has_point_times(const Drive& drive);

// The drive with a time for each point ("Times of points and several sensors" in
// schemas/definitions.md), half of a scan before its stamp and half behind it, since a scan taken
// as rigid is matched where its middle was. One drive where the order of the points is that of time
// (sweep_times), one for each possible turn where rings follow each other (turns_of_rings). One
// pose for each scan. None where a scan has times of its own, where there are several sensors, and
// where the first and the middle scan are in another order.
Result<std::vector<Drive>> swept_drives(const Drive& drive, const Trajectory& trajectory);

// The times of a scan's points by their order alone: a spinning LiDAR that writes points as it
// fires them turns once about its z axis from the first to the last. Of each point the share of the
// scan's time, 0 to 1, by the azimuth that its neighbours in the order reached. Empty where the
// order is another one (ring by ring, sorted, filtered at random), or covers less than 300 or more
// than 450 degrees. Points in the sensor's frame, metres.
std::vector<double> sweep_times(std::span<const Eigen::Vector3d> points_m);

// How a spinning LiDAR turned during a scan: once round its z axis, from the azimuth where it
// began.
struct SweepTurn {
  double begin_rad = 0.0;
  bool is_clockwise = false;  // seen from above
};

// The turns that may have measured a scan whose file contains ring after ring, each point beside
// the one before it, so that their order does not give their times: from the azimuth where the
// stored rings begin, and from behind (as cameras that look ahead are triggered) in both
// directions. Empty where points are in another order. Points in the sensor's frame, metres.
std::vector<SweepTurn> turns_of_rings(std::span<const Eigen::Vector3d> points_m);

// The time of each point as the share of the scan's time, 0 to 1, by its azimuth.
std::vector<double> turn_times(std::span<const Eigen::Vector3d> points_m, const SweepTurn& turn);

// At most 60 scans of a drive, and their poses: scans on which the vehicle moves 5 m, since it may
// stand at a light in the middle. Of these the ones with the fewest unconstrained poses, nearest to
// the middle: sharpness is no evidence where scans do not constrain the way. Those of the middle
// where the vehicle never moves. Scans count from 0 anew.
Drive middle_of(const Drive& drive, const Trajectory& trajectory);
Trajectory middle_of(const Trajectory& trajectory);

// Length of the way along the poses, without the steps from one piece to the next.
double way_m(const Trajectory& trajectory);

// Mean map entropy of the scans of the middle ("Sharpness" in schemas/definitions.md), nat.
Result<double> middle_entropy_nat(PassContext& ctx, const Drive& drive,
                                  const Trajectory& trajectory);

// Whether entropies differ by more than noise does.
bool is_sharper(double after_nat, double before_nat);

// A drive without times, with times by the order of its points: where several are possible
// (swept_drives), those by which the scans, undistorted with the trajectory, are sharpest. None
// where the order gives no times.
Result<std::optional<Drive>> sharpest_sweep(PassContext& ctx, const Drive& drive,
                                            const Trajectory& trajectory);

// Whether the scans undistorted with the trajectory are sharper than the scans as they are.
Result<bool> is_sharper_undistorted(PassContext& ctx, const Drive& drive, const Drive& undistorted,
                                    const Trajectory& trajectory);

}  // namespace sightline
