#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/geometry.h"

// The result of following a drive from scan to scan; part of estimate-trajectory.

namespace sightline {

// Why a piece begins at a scan.
struct PieceStart {
  std::uint32_t scan = 0;
  bool is_time_jump = false;       // else no place near the last scan fits
  double overlap = 0.0;            // the largest with earlier scans; 0 where no place was found
  double overlap_elsewhere = 0.0;  // in another place than that one
};

// What leads where scans do not constrain a motion: given poses, constant speed, the speed of the
// wheels, or the accelerations of an inertial unit.
enum class Forecast : std::uint8_t { kNone, kGiven, kSteady, kWheels, kInertial };

// Drivers change their speed by a few percent within half a minute.
inline constexpr double kSteadyShare = 0.05;

// What the scans constrain of a step (ScanConstraint).
struct StepConstraint {
  double sigma_m = 0.0;  // of the least constrained motion; 0: not known
  // By axis, forward, left and turn: how much of it is not constrained, 0 to 1.
  Eigen::Vector3d weak = Eigen::Vector3d::Zero();
  Forecast forecast = Forecast::kNone;  // what was used instead; none: the match all the same
  // Projects a motion (PlanarMotion) onto what was used instead of the match; zero: nothing.
  Eigen::Matrix3d forecast_motions = Eigen::Matrix3d::Zero();
  // Standard deviation of the way that was forecast, as a share of it; the same error all along a
  // stretch.
  double way_share = kSteadyShare;
  // By axis: the share of an error of the forecast that the surfaces leave (kept_shares), 0 to 1.
  // Poses are named by it.
  Eigen::Vector3d kept = Eigen::Vector3d::Zero();
  // Forward and left, m: how far a match is from the motion before it, where no vehicle changes its
  // speed so much; zero elsewhere. This step, or steps before it, may be wrong by as much.
  Eigen::Vector2d leap_m = Eigen::Vector2d::Zero();
};

struct Odometry {
  std::vector<Pose> T_map_lidar;  // one a scan
  std::vector<bool> is_matched;   // false: carried on from given poses or begins a piece
  std::vector<bool> is_far;       // found by a search: its step is less accurate than others
  std::vector<double> driven_m;   // arc length up to each scan; a piece begins where the last ended
  // Scans of one piece are known relative to each other, ascending numbers from 0.
  std::vector<std::uint32_t> piece;
  std::vector<PieceStart> piece_starts;  // of every piece but the first
  // Share of the scan's upright returns that meet the local map (UprightMap); none where there
  // are too few, where a piece begins, and where given poses lead to all scans.
  std::vector<std::optional<double>> overlap;
  std::vector<StepConstraint> constraint;  // of the step to each scan

  // Adds a scan to the last piece, `step_m` of way after the scan before it.
  void append(const Pose& T_map_scan, double step_m, bool matched,
              std::optional<double> scan_overlap);
  // Adds a scan whose pose is known already, as one of the last piece or as the first of another.
  void append_known(const Pose& T_map_scan, bool begins_piece, std::optional<double> scan_overlap);
};

// A measurement of one pose relative to another; sigmas are standard deviations of each axis.
struct GraphEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  Pose T_from_to = Pose::Identity();
  double sigma_m = 0.1;
  double sigma_rad = 0.01;
  // Covariance in addition to the sigmas: translation, then rotation, in the axes of `from`.
  Eigen::Matrix<double, 6, 6> more = Eigen::Matrix<double, 6, 6>::Zero();
};

// Scans [begin, end) of a drive.
struct ScanRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  [[nodiscard]] std::uint32_t size() const { return end - begin; }
};
// The first scan of a range, and each next one after `step_m` of way.
std::vector<std::uint32_t> scans_every(const Odometry& odometry, const ScanRange& range,
                                       double step_m);
// Runs of scans with one piece number; a piece that another one interrupts is several.
std::vector<ScanRange> ranges_of(const std::vector<std::uint32_t>& piece);

}  // namespace sightline
