#include "formats/drive/drive.h"

#include <algorithm>

namespace sightline {
namespace {

class MemoryScanStore : public ScanStore {
 public:
  explicit MemoryScanStore(std::vector<Scan> scans) : scans_(std::move(scans)) {}

  Result<Scan> read(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    return scans_[index];
  }

  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    SIGHTLINE_CHECK(index < scans_.size());
    const Scan& scan = scans_[index];
    ByteWriter writer;
    writer.put(scan.stamp_ns);
    writer.append(scan.points_m.data(), scan.points_m.size() * sizeof(Eigen::Vector3d));
    writer.put_array(scan.time_offset_ns);
    return sha256(writer.bytes());
  }

 private:
  std::vector<Scan> scans_;
};

Error invalid_scan(std::size_t scan, const std::string& what) {
  return {ErrorCode::kInvalidArtifact, what, "", concat("scan ", scan)};
}

// Samples of a sensor beside the LiDAR. Errors: time-runs-backwards, invalid-artifact.
template <class Sample>
Result<void> check_samples(const std::vector<Sample>& samples, const std::string& what) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::string place = concat(what, " ", i);
    if (!are_finite(samples[i])) {
      return Error{ErrorCode::kInvalidArtifact, "it is not finite", "", place};
    }
    if (i > 0 && samples[i].stamp_ns <= samples[i - 1].stamp_ns) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   "its time is not after that of the sample before it", "", place};
    }
  }
  return {};
}

// Errors: time-runs-backwards, invalid-artifact.
Result<void> check_order(const Drive& drive, std::size_t i) {
  const ScanInfo& scan = drive.scans[i];
  const ScanInfo& before = drive.scans[i - 1];
  const bool is_later =
      scan.stamp_ns > before.stamp_ns ||
      (scan.stamp_ns == before.stamp_ns && scan.sensor_index > before.sensor_index);
  if (!is_later) {
    return Error{ErrorCode::kTimeRunsBackwards, "its time is not after that of the scan before it",
                 scan.source, concat("scan ", i)};
  }
  const std::uint32_t step = scan.part - before.part;
  if (step > 1 || (step == 1 && scan.stamp_ns - before.stamp_ns < kPauseBetweenParts_ns)) {
    return invalid_scan(i, "its part of the drive does not follow that of the scan before it");
  }
  if (scan.recording_index <= before.recording_index) {
    return invalid_scan(i, "its place in the recording is not after that of the scan before it");
  }
  return {};
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

const SensorProfile& Drive::sensor_of(const ScanInfo& scan) const {
  if (scan.sensor_index == 0) return sensor;
  SIGHTLINE_CHECK(scan.sensor_index <= other_sensors.size());
  return other_sensors[scan.sensor_index - 1];
}

const std::string& Drive::name_of_part(std::uint32_t part) const {
  if (part == 0) return name;
  SIGHTLINE_CHECK(part <= later_parts.size());
  return later_parts[part - 1];
}

std::string Drive::names_of_parts() const {
  std::string names = name;
  for (const std::string& part : later_parts) names += ", " + part;
  return names;
}

bool is_selected(const ScanInfo& scan, ScanSelection selection) {
  const bool is_even = scan.recording_index % 2 == 0;
  return selection == ScanSelection::kAll || is_even == (selection == ScanSelection::kEven);
}

Result<void> validate(const Drive& drive) {
  SIGHTLINE_TRY(validate(drive.sensor));
  for (const Notice& notice : drive.notices) SIGHTLINE_TRY(validate(notice));
  for (const SensorProfile& other : drive.other_sensors) {
    SIGHTLINE_TRY(validate(other));
  }
  if (!drive.frame.origin_world_m.allFinite()) {
    return Error{ErrorCode::kInvalidArtifact, "the map frame's origin is not finite"};
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const ScanInfo& scan = drive.scans[i];
    if (scan.T_world_vehicle && !is_rigid(*scan.T_world_vehicle)) {
      return invalid_scan(i, "its pose is not a rotation and translation");
    }
    if (scan.part > drive.later_parts.size() || (i == 0 && scan.part != 0)) {
      return invalid_scan(i, "it is of a part that the drive does not have");
    }
    if (scan.sensor_index > drive.other_sensors.size()) {
      return invalid_scan(i, "it is of a sensor that the drive does not have");
    }
    SIGHTLINE_TRY(i == 0 ? Result<void>() : check_order(drive, i));
  }
  SIGHTLINE_TRY(check_samples(drive.turn_rates, "turn rate"));
  SIGHTLINE_TRY(check_samples(drive.specific_forces, "specific force"));
  return check_samples(drive.wheel_speeds, "wheel speed");
}

Table dump(const Drive& drive) {
  Table table{"drive", {}, {}, {}};
  table.facts = {{"drive", drive.name},
                 {"sensor", drive.sensor.name},
                 {"frame_origin_x_m", drive.frame.origin_world_m.x()},
                 {"frame_origin_y_m", drive.frame.origin_world_m.y()},
                 {"frame_origin_z_m", drive.frame.origin_world_m.z()}};
  for (const SensorProfile& other : drive.other_sensors) {
    table.facts.emplace_back("other_sensor", other.name);
  }
  for (const std::string& part : drive.later_parts) table.facts.emplace_back("later_part", part);
  for (const Notice& notice : drive.notices) {
    table.facts.emplace_back("notice." + notice.code, notice.text);
  }
  const auto add_count = [&](const char* name, std::size_t count) {
    if (count > 0) table.facts.emplace_back(name, static_cast<std::int64_t>(count));
  };
  add_count("turn_rates", drive.turn_rates.size());
  add_count("specific_forces", drive.specific_forces.size());
  add_count("wheel_speeds", drive.wheel_speeds.size());
  table.columns = {"recording_index", "sensor_index",    "stamp_ns",   "source",
                   "point_count",     "nonfinite_count", "zero_count", "has_point_times"};
  const bool has_parts = !drive.later_parts.empty();
  if (has_parts) table.columns.emplace_back("part");
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      table.columns.push_back(concat("T_world_vehicle_", row, column));
    }
  }
  for (const ScanInfo& scan : drive.scans) {
    std::vector<Cell>& cells = table.rows.emplace_back();
    cells = {static_cast<std::int64_t>(scan.recording_index),
             static_cast<std::int64_t>(scan.sensor_index),
             scan.stamp_ns,
             scan.source,
             static_cast<std::int64_t>(scan.point_count),
             static_cast<std::int64_t>(scan.nonfinite_count),
             static_cast<std::int64_t>(scan.zero_count),
             std::int64_t{scan.has_point_times ? 1 : 0}};
    if (has_parts) cells.emplace_back(static_cast<std::int64_t>(scan.part));
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        cells.push_back(scan.T_world_vehicle ? Cell((*scan.T_world_vehicle)(row, column))
                                             : Cell(std::string()));
      }
    }
  }
  return table;
}

Drive with_store(Drive drive, std::shared_ptr<const ScanStore> store) {
  drive.store = std::move(store);
  return drive;
}

}  // namespace sightline
