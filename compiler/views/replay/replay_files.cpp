#include "compiler/views/replay/replay_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "formats/drive/look.h"
#include "formats/foreign/ros/files/mcap_writer.h"
#include "formats/foreign/ros/message_writer.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/foreign/text/stamp.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

// The frame that poses are in: the world of the map, by the name that ROS programs use for it.
constexpr std::string_view kFrame = "map";

bool is_localized(const ReplayedScan& scan) { return scan.state == ScanState::kLocalized; }

std::string look_text(const MapLook& look) {
  return to_text(Look{.range_m = look.range_m,
                      .return_count = look.return_count,
                      .even_beyond_m = look.even_beyond_m,
                      .point_count = look.point_count,
                      .is_by_normals = look.is_by_normals,
                      .mode = look.settles ? LookMode::kSettle : LookMode::kSearch});
}

std::string weak_text(std::uint32_t weak) {
  constexpr std::array<std::string_view, 6> kAxes = {"forward", "left",  "up",
                                                     "roll",    "pitch", "yaw"};
  std::string text;
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    if ((weak >> axis & 1U) == 0) continue;
    text += (text.empty() ? "" : " ") + std::string(kAxes[axis]);
  }
  return text;
}

std::string state_text(const ReplayedScan& scan) {
  return is_localized(scan) && scan.is_in_doubt ? "in doubt" : std::string(name_of(scan.state));
}

Result<void> write_tum_of(const std::filesystem::path& file, const std::vector<ListedScan>& scans,
                          const ReplayedDrive& drive, IfExists if_exists) {
  std::vector<PoseRow> rows;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!is_localized(drive.scans[i])) continue;
    rows.push_back({scans[i].stamp_ns, std::nullopt, drive.scans[i].T_world_vehicle});
  }
  return write_tum(file, rows, if_exists);
}

std::vector<Cell> row_of(std::size_t number, const ListedScan& listed, const ReplayedScan& scan) {
  std::vector<Cell> row = {static_cast<std::int64_t>(number), listed.name,
                           format_stamp(listed.stamp_ns), state_text(scan)};
  constexpr std::size_t kOfPose = 7 + 6 + 4;
  if (!is_localized(scan)) {
    row.insert(row.end(), kOfPose, Cell(std::string()));
    return row;
  }
  append_cells(scan.T_world_vehicle, row);
  for (int axis = 0; axis < 6; ++axis) {
    row.emplace_back(std::sqrt(std::max(0.0, scan.covariance(axis, axis))));
  }
  row.emplace_back(look_text(scan.look));
  row.emplace_back(static_cast<std::int64_t>(scan.look_count));
  row.emplace_back(static_cast<std::int64_t>(scan.point_count));
  row.emplace_back(weak_text(scan.weak));
  return row;
}

Status status_of(const ListedScan& listed, const ReplayedScan& scan) {
  Status status;
  status.level = !is_localized(scan) ? StatusLevel::kError
                 : scan.is_in_doubt  ? StatusLevel::kWarning
                                     : StatusLevel::kOk;
  status.name = "sightline: localization";
  status.message = state_text(scan);
  status.values = {{"scan", listed.name},
                   {"look", look_text(scan.look)},
                   {"looks taken", std::to_string(scan.look_count)},
                   {"points matched", std::to_string(scan.point_count)},
                   {"weak axes", weak_text(scan.weak)}};
  return status;
}

// Bytes in memory are always taken.
Result<void> fill(const std::vector<ListedScan>& scans, const ReplayedDrive& drive,
                  McapWriter& writer) {
  const std::uint16_t pose = writer.add_topic("/sightline/pose", kPoseWithCovarianceStamped);
  const std::uint16_t path = writer.add_topic("/sightline/path", kPath);
  const std::uint16_t status = writer.add_topic("/diagnostics", kDiagnosticArray);
  std::vector<StampedPose> way;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (is_localized(drive.scans[i])) {
      way.push_back({scans[i].stamp_ns, drive.scans[i].T_world_vehicle});
    }
  }
  if (!way.empty()) {
    SIGHTLINE_TRY(writer.add(path, way.front().stamp_ns, path_message(kFrame, way)));
  }
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const ReplayedScan& scan = drive.scans[i];
    const std::int64_t stamp_ns = scans[i].stamp_ns;
    if (scan.state == ScanState::kSkipped) continue;
    if (is_localized(scan)) {
      SIGHTLINE_TRY(writer.add(
          pose, stamp_ns, pose_message(stamp_ns, kFrame, scan.T_world_vehicle, scan.covariance)));
    }
    SIGHTLINE_TRY(
        writer.add(status, stamp_ns, status_message(stamp_ns, kFrame, status_of(scans[i], scan))));
  }
  return writer.finish();
}

}  // namespace

Table poses_table(const std::vector<ListedScan>& scans, const ReplayedDrive& drive) {
  Table table;
  table.name = "poses";
  table.columns = {"scan", "file", "t_s", "state"};
  append_pose_columns(table.columns);
  for (const char* column : {"std_x_m", "std_y_m", "std_z_m", "std_about_x_rad", "std_about_y_rad",
                             "std_about_z_rad", "look", "looks_taken", "points", "weak"}) {
    table.columns.emplace_back(column);
  }
  for (std::size_t i = 0; i < scans.size(); ++i) {
    table.rows.push_back(row_of(i, scans[i], drive.scans[i]));
  }
  return table;
}

std::vector<std::byte> poses_mcap(const std::vector<ListedScan>& scans,
                                  const ReplayedDrive& drive) {
  std::vector<std::byte> bytes;
  const ByteSink file = [&](std::span<const std::byte> more) -> Result<void> {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return {};
  };
  McapWriter writer(file);
  const Result<void> filled = fill(scans, drive, writer);
  SIGHTLINE_CHECK(filled.has_value());
  return bytes;
}

Result<void> write_poses(const std::filesystem::path& file, const std::vector<ListedScan>& scans,
                         const ReplayedDrive& drive, IfExists if_exists) {
  const std::string ending = file.extension().string();
  if (ending == ".csv") {
    return write_file_atomically(file, format_table(poses_table(scans, drive), TableFormat::kCsv),
                                 if_exists);
  }
  if (ending != ".mcap") return write_tum_of(file, scans, drive, if_exists);
  return write_file_atomically(
      file,
      [&](const ByteSink& bytes) -> Result<void> {
        McapWriter writer(bytes);
        return fill(scans, drive, writer);
      },
      if_exists);
}

}  // namespace sightline
