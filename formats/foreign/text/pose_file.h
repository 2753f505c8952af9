#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/base/result.h"
#include "formats/foreign/text/stamp.h"
#include "formats/geometry.h"

namespace sightline {

// One row of a pose file. Whose pose it is (the vehicle's or the sensor's) no file says; the name
// follows the default.
struct PoseRow {
  std::optional<std::int64_t> stamp_ns;
  std::optional<std::int64_t> id;
  Pose T_world_vehicle = Pose::Identity();
};

enum class PoseFormat {
  kAuto,    // by the number of columns
  kKitti,   // 12: the upper three rows of the matrix, row by row
  kTum,     // 8: t x y z qx qy qz qw
  kApollo,  // 9: id t x y z qx qy qz qw
};

// Reads poses, one a line; blank lines, lines that begin with # and a first line that names the
// columns of kTum in their order are skipped, columns may be apart by blanks, tabs or commas.
// Rotations that are off by rounding (norm of a quaternion or products of the matrix's rows within
// 1e-3) are made exact; times are taken from their decimal digits, so nanoseconds survive. Errors,
// with the line: file-not-found, cannot-read, git-lfs-pointer, malformed-pose, not-a-rotation,
// time-runs-backwards (a time before that of the row before; or more rows than kRepeatedTimesShare
// with an equal one: a few are kept, for the caller to count).
inline constexpr double kRepeatedTimesShare = 0.05;
Result<std::vector<PoseRow>> read_poses(const std::filesystem::path& path, PoseFormat format);

// The pose at a time between two rows of ascending times, interpolated; nothing where the rows
// before and after it are more than 1.5 s apart, or there are none.
std::optional<PoseRow> pose_at(const std::vector<PoseRow>& rows, std::int64_t stamp_ns);

// Writes "t x y z qx qy qz qw", with every digit that reads back as the same number; a row without
// a time takes its index as seconds. Errors: output-exists, disk-full, cannot-write.
Result<void> write_tum(const std::filesystem::path& path, std::span<const PoseRow> rows,
                       IfExists if_exists = IfExists::kRefuse);

// One time a line, as in a pose file; further columns are ignored.
// Errors as read_poses (a few equal times are kept), malformed-text for what is no time.
Result<std::vector<std::int64_t>> read_stamps(const std::filesystem::path& path);

}  // namespace sightline
