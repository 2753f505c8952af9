#include "formats/drive.h"

#include <algorithm>
#include <limits>

namespace sightline {
namespace {

class MemoryScanStore : public ScanStore {
 public:
  explicit MemoryScanStore(std::vector<Scan> scans) : scans_(std::move(scans)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    return scans_[index];
  }

 private:
  std::vector<Scan> scans_;
};

Error invalid(std::size_t scan, const std::string& what) {
  return {ErrorCode::kInvalidArtifact, what, "", "scan " + std::to_string(scan)};
}

void encode(const ScanInfo& scan, ByteWriter& writer) {
  writer.put(scan.recording_index);
  writer.put(scan.stamp_ns);
  writer.put_string(scan.source);
  writer.put(scan.point_count);
  writer.put(scan.nonfinite_count);
  writer.put(scan.zero_count);
  writer.put<std::uint8_t>(scan.T_world_vehicle.has_value() ? 1 : 0);
  if (scan.T_world_vehicle) encode(*scan.T_world_vehicle, writer);
}

void decode(ByteReader& reader, ScanInfo& scan) {
  reader.get(scan.recording_index);
  reader.get(scan.stamp_ns);
  reader.get_string(scan.source);
  reader.get(scan.point_count);
  reader.get(scan.nonfinite_count);
  reader.get(scan.zero_count);
  const auto has_pose = reader.get<std::uint8_t>();
  if (has_pose > 1) reader.fail();
  if (has_pose == 1) decode(reader, scan.T_world_vehicle.emplace());
}

}  // namespace

std::shared_ptr<const ScanStore> memory_scan_store(std::vector<Scan> scans) {
  return std::make_shared<MemoryScanStore>(std::move(scans));
}

bool Drive::has_poses() const {
  return !scans.empty() && std::ranges::all_of(scans, [](const ScanInfo& scan) {
    return scan.T_world_vehicle.has_value();
  });
}

bool is_selected(const ScanInfo& scan, ScanSelection selection) {
  switch (selection) {
    case ScanSelection::kAll:
      return true;
    case ScanSelection::kEven:
      return scan.recording_index % 2 == 0;
    case ScanSelection::kOdd:
      return scan.recording_index % 2 == 1;
  }
  return true;
}

Result<void> validate(const Drive& drive) {
  const Result<void> sensor = validate(drive.sensor);
  if (!sensor) return sensor.error();
  if (!drive.frame.origin_world_m.allFinite()) {
    return Error{ErrorCode::kInvalidArtifact, "the map frame's origin is not finite", "", ""};
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const ScanInfo& scan = drive.scans[i];
    if (scan.T_world_vehicle && !is_rigid(*scan.T_world_vehicle)) {
      return invalid(i, "its pose is no rotation and translation");
    }
    if (i == 0) continue;
    if (scan.stamp_ns <= drive.scans[i - 1].stamp_ns) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   "its time is not after that of the scan before it", scan.source,
                   "scan " + std::to_string(i)};
    }
    if (scan.recording_index <= drive.scans[i - 1].recording_index) {
      return invalid(i, "its place in the recording is not after that of the scan before it");
    }
  }
  return {};
}

Table dump(const Drive& drive) {
  Table table;
  table.name = "drive";
  table.facts = {{"drive", drive.name},
                 {"sensor", drive.sensor.name},
                 {"frame_origin_x_m", drive.frame.origin_world_m.x()},
                 {"frame_origin_y_m", drive.frame.origin_world_m.y()},
                 {"frame_origin_z_m", drive.frame.origin_world_m.z()}};
  table.columns = {"recording_index", "stamp_ns",        "source",
                   "point_count",     "nonfinite_count", "zero_count"};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      table.columns.push_back("T_world_vehicle_" + std::to_string(row) + std::to_string(column));
    }
  }
  for (const ScanInfo& scan : drive.scans) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells = {static_cast<std::int64_t>(scan.recording_index),
             scan.stamp_ns,
             scan.source,
             static_cast<std::int64_t>(scan.point_count),
             static_cast<std::int64_t>(scan.nonfinite_count),
             static_cast<std::int64_t>(scan.zero_count)};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        cells.push_back(scan.T_world_vehicle ? Cell((*scan.T_world_vehicle)(row, column))
                                             : Cell(std::string()));
      }
    }
  }
  return table;
}

void encode(const Drive& drive, ByteWriter& writer) {
  writer.put_string(drive.name);
  encode(drive.sensor, writer);
  encode(drive.frame, writer);
  writer.put<std::uint64_t>(drive.scans.size());
  for (const ScanInfo& scan : drive.scans) encode(scan, writer);
}

void decode(ByteReader& reader, Drive& drive) {
  // The fixed part of a scan without a pose.
  constexpr std::size_t kLeastScanSize = 4 + 8 + 8 + 3 * 8 + 1;
  reader.get_string(drive.name);
  decode(reader, drive.sensor);
  decode(reader, drive.frame);
  drive.scans.clear();
  drive.scans.resize(reader.get_count(kLeastScanSize));
  for (ScanInfo& scan : drive.scans) decode(reader, scan);
}

Drive with_store(Drive drive, std::shared_ptr<const ScanStore> store) {
  drive.store = std::move(store);
  return drive;
}

}  // namespace sightline
