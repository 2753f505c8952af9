#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/drive/drive.h"
#include "formats/drive/notice.h"
#include "formats/drive/unconstrained.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"

namespace sightline {

enum class PoseSource : std::uint8_t { kGiven, kRefined, kEstimated };
template <>
inline constexpr auto kNamesOf<PoseSource> = enum_names("given", "refined", "estimated");

// Of a pose, 6 x 6: see TrajectoryPose. Zero takes no memory and copies share what they hold: a
// street has many poses, held more than once, and where poses are given none has a covariance.
class PoseCovariance {
 public:
  using Matrix = Eigen::Matrix<double, 6, 6>;
  PoseCovariance() = default;
  PoseCovariance(const Matrix& matrix);  // NOLINT(google-explicit-constructor)

  [[nodiscard]] const Matrix& matrix() const;
  double operator()(int row, int column) const { return matrix()(row, column); }

 private:
  std::shared_ptr<const Matrix> matrix_;  // nullptr: zero
};

struct TrajectoryPose {
  std::uint32_t recording_index = 0;  // of the scan
  std::int64_t stamp_ns = 0;
  Pose T_map_vehicle = Pose::Identity();
  // Of a small motion of the pose, x -> t + dt + exp([w]x) R q, in map axes: dt (m), then w (rad).
  // Zero where poses were given.
  PoseCovariance covariance = {};
  // Poses of one piece are known relative to each other; how pieces lie to each other is not known.
  std::uint32_t piece = 0;
  // Share of the scan's upright returns that meet what was seen before it ("Overlap" in
  // schemas/definitions.md, v1); none where it was not measured.
  std::optional<double> overlap = std::nullopt;
  // Whether its scan is laid into the map: beside an earlier map (`base`) one that shows nothing
  // new is not, and no pass behind choose-scans takes it.
  bool is_laid = true;
  // What scans do not constrain of the motion to this pose; the same along a stretch of such poses.
  Unconstrained unconstrained = {};
};
// An overlap that was not measured is -1. The highest bits of `piece` hold is_laid and
// `unconstrained`, and are 0 where a scan is laid and constrained.
void encode(const TrajectoryPose& pose, ByteWriter& writer);
void decode(ByteReader& reader, TrajectoryPose& pose);

// Where the vehicle was at each scan of a drive, in `frame`; one pose per scan, in time order.
// Pieces are numbered 0, 1, 2, ... in the order of their first scans.
struct Trajectory {
  MapFrame frame;
  PoseSource source = PoseSource::kGiven;
  std::vector<TrajectoryPose> poses;
  // Of the pose graph, over its odometry and loop edges; 0 where poses were given.
  std::uint32_t odometry_edges = 0;
  std::uint32_t loop_edges = 0;
  std::uint32_t prior_edges = 0;
  double rms_translation_residual_m = 0.0;
  double rms_rotation_residual_rad = 0.0;
  std::vector<Notice> notices = {};  // of given poses and of the poses found
};
SIGHTLINE_FIELDS(Trajectory, frame, source, odometry_edges, loop_edges, prior_edges,
                 rms_translation_residual_m, rms_rotation_residual_rad, poses, notices)
SIGHTLINE_ARTIFACT(Trajectory, "trajectory", 4)

// The same poses in another map frame of the same world.
Trajectory rebase(const Trajectory& trajectory, const MapFrame& to);

Result<void> validate(const Trajectory& trajectory);
Table dump(const Trajectory& trajectory);

// Whether `trajectory` has one pose for each scan of `drive`, in its order.
// Error: mismatched-inputs, naming the first pose that is of another scan.
Result<void> check_trajectory_of_drive(const Drive& drive, const Trajectory& trajectory);

// Where the scans of a map were when it was shipped, so that the next one, made of these drives and
// of more, moves nothing of it. A file of its own beside the map (.slposes).
struct ReleasedPoses {
  Trajectory trajectory;
  std::vector<Digest> scans;  // of each pose: which scan (ScanStore::identity)
};
SIGHTLINE_FIELDS(ReleasedPoses, trajectory, scans)
SIGHTLINE_ARTIFACT(ReleasedPoses, "released-poses", 2)

// The poses of a drive to be shipped. Error: invalid-artifact (scans that have no identity).
Result<ReleasedPoses> release(const Drive& drive, const Trajectory& trajectory);

// Which pose each scan of a drive has; nullptr where none was released. Refers to `released`.
std::vector<const TrajectoryPose*> poses_of(const Drive& drive, const ReleasedPoses& released);

Result<void> validate(const ReleasedPoses& released);
Table dump(const ReleasedPoses& released);

}  // namespace sightline
