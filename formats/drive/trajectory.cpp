#include "formats/drive/trajectory.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "formats/drive/drive.h"
#include "formats/record/cells.h"

namespace sightline {
namespace {

Error invalid_pose(std::size_t pose, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("pose ", pose)};
}

// Symmetric to the last bit: only one triangle is written.
bool is_covariance(const PoseCovariance::Matrix& covariance) {
  return covariance.allFinite() && covariance == covariance.transpose() &&
         covariance.diagonal().minCoeff() >= 0.0;
}

void encode(const PoseCovariance& covariance, ByteWriter& writer) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) writer.put(covariance(i, j));
  }
}

PoseCovariance decode_covariance(ByteReader& reader) {
  PoseCovariance::Matrix covariance = PoseCovariance::Matrix::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      reader.get(covariance(i, j));
      covariance(j, i) = covariance(i, j);
    }
  }
  return covariance;
}

constexpr double kNotMeasured = -1.0;  // an overlap
// Bits beside the number of a piece: its scan is not laid into the map, directions that are not
// constrained, and what was used instead.
constexpr std::uint32_t kNotLaid = std::uint32_t{1} << 31;
constexpr std::uint32_t kAlong = std::uint32_t{1} << 30;
constexpr std::uint32_t kAcross = std::uint32_t{1} << 29;
constexpr std::uint32_t kHeading = std::uint32_t{1} << 28;
constexpr std::uint32_t kSubstituteShift = 25;
constexpr std::uint32_t kSubstitute = std::uint32_t{7} << kSubstituteShift;
constexpr std::uint32_t kPiece = (std::uint32_t{1} << kSubstituteShift) - 1;

std::uint32_t bits_of(const TrajectoryPose& pose) {
  const Unconstrained& weak = pose.unconstrained;
  return (pose.is_laid ? 0 : kNotLaid) | (weak.along ? kAlong : 0) | (weak.across ? kAcross : 0) |
         (weak.heading ? kHeading : 0) |
         (static_cast<std::uint32_t>(weak.substitute) << kSubstituteShift);
}

void set_bits(std::uint32_t bits, TrajectoryPose& pose) {
  pose.is_laid = (bits & kNotLaid) == 0;
  pose.unconstrained = {(bits & kAlong) != 0, (bits & kAcross) != 0, (bits & kHeading) != 0,
                        static_cast<Substitute>((bits & kSubstitute) >> kSubstituteShift)};
}

bool is_known(const Unconstrained& weak) {
  return !name_of(weak.substitute).empty() &&
         (weak.is_any() || weak.substitute == Substitute::kNone);
}

bool is_residual(double value) { return std::isfinite(value) && value >= 0.0; }

}  // namespace

PoseCovariance::PoseCovariance(const Matrix& matrix) {
  // Minus zero is no zero: what is read is written again to the bit.
  const bool is_zero = std::ranges::all_of(
      matrix.reshaped(), [](double value) { return value == 0.0 && !std::signbit(value); });
  if (!is_zero) matrix_ = std::make_shared<const Matrix>(matrix);
}

const PoseCovariance::Matrix& PoseCovariance::matrix() const {
  static const Matrix zero = Matrix::Zero();
  return matrix_ ? *matrix_ : zero;
}

void encode(const TrajectoryPose& pose, ByteWriter& writer) {
  writer.put(pose.recording_index);
  writer.put(pose.stamp_ns);
  encode(pose.T_map_vehicle, writer);
  encode(pose.covariance, writer);
  writer.put(pose.piece | bits_of(pose));
  writer.put(pose.overlap.value_or(kNotMeasured));
}

void decode(ByteReader& reader, TrajectoryPose& pose) {
  reader.get(pose.recording_index);
  reader.get(pose.stamp_ns);
  decode(reader, pose.T_map_vehicle);
  pose.covariance = decode_covariance(reader);
  const auto piece = reader.get<std::uint32_t>();
  pose.piece = piece & kPiece;
  set_bits(piece, pose);
  const auto overlap = reader.get<double>();
  if (overlap != kNotMeasured) pose.overlap = overlap;
}

Trajectory rebase(const Trajectory& trajectory, const MapFrame& to) {
  Trajectory moved = trajectory;
  moved.frame = to;
  for (TrajectoryPose& pose : moved.poses) {
    pose.T_map_vehicle = rebase(pose.T_map_vehicle, trajectory.frame, to);
  }
  return moved;
}

Result<void> validate(const Trajectory& trajectory) {
  if (!trajectory.frame.origin_world_m.allFinite() || name_of(trajectory.source).empty() ||
      !is_residual(trajectory.rms_translation_residual_m) ||
      !is_residual(trajectory.rms_rotation_residual_rad)) {
    return Error{ErrorCode::kInvalidArtifact,
                 "the trajectory's origin, source or residuals are invalid"};
  }
  for (const Notice& notice : trajectory.notices) SIGHTLINE_TRY(validate(notice));
  std::uint32_t pieces = 0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    if (!is_known(pose.unconstrained)) return invalid_pose(i, "found an unknown substitute");
    if (pose.piece > kPiece || pose.piece > pieces ||
        (pose.overlap && !(*pose.overlap >= 0.0 && *pose.overlap <= 1.0))) {
      return invalid_pose(i, "a piece is out of order, or an overlap is outside 0 to 1");
    }
    pieces = std::max(pieces, pose.piece + 1);
    if (!is_rigid(pose.T_map_vehicle)) {
      return invalid_pose(i, "found a pose that is not a rigid motion");
    }
    if (!is_covariance(pose.covariance.matrix())) {
      return invalid_pose(i, "found a covariance that is not finite, symmetric and positive");
    }
    if (i == 0) continue;
    const TrajectoryPose& before = trajectory.poses[i - 1];
    if (pose.recording_index <= before.recording_index) {
      return invalid_pose(i, concat("found recording index ", pose.recording_index, " after ",
                                    before.recording_index, ", expected ascending ones"));
    }
    if (pose.stamp_ns < before.stamp_ns) {
      return invalid_pose(i, concat("found stamp ", pose.stamp_ns, " after ", before.stamp_ns,
                                    " ns, expected ascending ones"));
    }
  }
  return {};
}

Table dump(const Trajectory& trajectory) {
  Table table{"trajectory", {}, {}, {}};
  append_facts(trajectory.frame, table);
  append_facts(trajectory, table);
  for (const Notice& notice : trajectory.notices) {
    table.facts.emplace_back("notice." + notice.code, notice.text);
  }
  table.columns = {"recording_index", "stamp_ns"};
  append_pose_columns(table.columns);
  const std::vector<std::string> sigmas = {"sigma_x_m",    "sigma_y_m",    "sigma_z_m",
                                           "sigma_rx_rad", "sigma_ry_rad", "sigma_rz_rad",
                                           "piece",        "overlap"};
  table.columns.insert(table.columns.end(), sigmas.begin(), sigmas.end());
  const bool are_all_laid = std::ranges::all_of(trajectory.poses, &TrajectoryPose::is_laid);
  if (!are_all_laid) table.columns.emplace_back("is_laid");
  const bool has_weak = std::ranges::any_of(
      trajectory.poses, [](const TrajectoryPose& pose) { return pose.unconstrained.is_any(); });
  if (has_weak) append_columns<Unconstrained>(table.columns);
  for (const TrajectoryPose& pose : trajectory.poses) {
    std::vector<Cell> row = {std::int64_t{pose.recording_index}, pose.stamp_ns};
    append_cells(pose.T_map_vehicle, row);
    for (int i = 0; i < 6; ++i) row.emplace_back(std::sqrt(pose.covariance(i, i)));
    row.emplace_back(std::int64_t{pose.piece});
    row.push_back(cell_of(pose.overlap));
    if (!are_all_laid) row.push_back(cell_of(pose.is_laid));
    if (has_weak) append_cells(pose.unconstrained, row);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Result<void> check_trajectory_of_drive(const Drive& drive, const Trajectory& trajectory) {
  if (trajectory.poses.size() != drive.scans.size()) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat("found ", trajectory.poses.size(), " poses for ", drive.scans.size(),
                        " scans, expected one each"),
                 "", "drive " + drive.name};
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (trajectory.poses[i].recording_index != drive.scans[i].recording_index) {
      return Error{ErrorCode::kMismatchedInputs,
                   concat("found the pose of scan ", trajectory.poses[i].recording_index,
                          ", expected that of scan ", drive.scans[i].recording_index),
                   "", concat("pose ", i)};
    }
  }
  return {};
}

Result<ReleasedPoses> release(const Drive& drive, const Trajectory& trajectory) {
  ReleasedPoses released;
  released.trajectory = trajectory;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::optional<Digest> scan = drive.store->identity(i);
    if (!scan) {
      return Error{ErrorCode::kInvalidArtifact,
                   "a scan has no name, which later maps need to recognize it", "",
                   concat("scan ", i)};
    }
    released.scans.push_back(*scan);
  }
  return released;
}

std::vector<const TrajectoryPose*> poses_of(const Drive& drive, const ReleasedPoses& released) {
  std::map<Digest, const TrajectoryPose*> pose_of_scan;
  for (std::size_t i = 0; i < released.scans.size(); ++i) {
    pose_of_scan.emplace(released.scans[i], &released.trajectory.poses[i]);
  }
  std::vector<const TrajectoryPose*> poses;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const std::optional<Digest> scan = drive.store->identity(i);
    const auto found = scan ? pose_of_scan.find(*scan) : pose_of_scan.end();
    poses.push_back(found == pose_of_scan.end() ? nullptr : found->second);
  }
  return poses;
}

Result<void> validate(const ReleasedPoses& released) {
  if (released.scans.size() != released.trajectory.poses.size()) {
    return Error{ErrorCode::kInvalidArtifact, concat("found ", released.scans.size(), " scans and ",
                                                     released.trajectory.poses.size(), " poses")};
  }
  return validate(released.trajectory);
}

Table dump(const ReleasedPoses& released) {
  Table table = dump(released.trajectory);
  table.name = "released-poses";
  table.columns.emplace_back("scan");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].emplace_back(to_hex(released.scans[i]));
  }
  return table;
}

}  // namespace sightline
