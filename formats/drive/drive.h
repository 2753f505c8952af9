#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/base/hash.h"
#include "formats/drive/notice.h"
#include "formats/drive/sensor_profile.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"

namespace sightline {

// How fast a vehicle turned at one time, as an inertial unit measured it: about the axes of the
// vehicle's frame, rad/s. The clock is that of the scans' stamps.
struct TurnRate {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
};
SIGHTLINE_FIELDS(TurnRate, stamp_ns, rate_rad_per_s)

// What an accelerometer measured at one time, about the axes of the vehicle's frame: acceleration
// less gravity, so upwards while the vehicle stands. The clock is that of the scans' stamps.
struct SpecificForce {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d force_m_s2 = Eigen::Vector3d::Zero();
};
SIGHTLINE_FIELDS(SpecificForce, stamp_ns, force_m_s2)

// How fast the wheels turned, as the speed of the vehicle at one time: negative backwards. Its
// scale may be off by percents. The clock is that of the scans' stamps.
struct WheelSpeed {
  std::int64_t stamp_ns = 0;
  double speed_m_s = 0.0;
};
SIGHTLINE_FIELDS(WheelSpeed, stamp_ns, speed_m_s)

// One revolution of the LiDAR: finite returns only, in the sensor's frame, metres.
struct Scan {
  std::int64_t stamp_ns = 0;
  std::vector<Eigen::Vector3d> points_m = {};
  // When each point was measured, ns after stamp_ns (before it where negative); empty: not known.
  std::vector<std::int32_t> time_offset_ns = {};
};

// Where the scans of a drive are. The one artifact that refers to something outside itself: a
// drive is larger than memory may be, so its scans are read one at a time.
class ScanStore {
 public:
  virtual ~ScanStore() = default;
  // The finite points of one scan, (0,0,0) left out. Safe from several threads.
  virtual Result<Scan> read(std::size_t index) const = 0;
  // Names what read() gives: equal names, equal scans, in whatever drive they are. Nothing where
  // that is not known without reading.
  [[nodiscard]] virtual std::optional<Digest> identity(std::size_t /*index*/) const {
    return std::nullopt;
  }
  // Whether each scan was seen from the origin of its frame: a piece of a finished map was not, and
  // nothing is known of what lies between.
  [[nodiscard]] virtual bool has_origins() const { return true; }
};

// Scans that are in memory already: generated ones, and those of tests.
std::shared_ptr<const ScanStore> memory_scan_store(std::vector<Scan> scans);

struct ScanInfo {
  std::uint32_t recording_index =
      0;  // 0-based position in the recording, before anything is skipped
  std::int64_t stamp_ns = 0;
  std::string source;                   // file name within the recording; empty in memory
  std::uint64_t point_count = 0;        // finite returns
  std::uint64_t nonfinite_count = 0;    // NaN or infinite, dropped
  std::uint64_t zero_count = 0;         // exactly (0,0,0), dropped
  std::optional<Pose> T_world_vehicle;  // as given, in the recording's own coordinates
  std::uint32_t sensor_index = 0;       // of the drive's sensors, see Drive::sensor_of
  std::uint32_t part = 0;               // of the drive's parts, see Drive::later_parts
  bool has_point_times = false;         // its points carry times of their own
};
SIGHTLINE_FIELDS(ScanInfo, recording_index, stamp_ns, source, point_count, nonfinite_count,
                 zero_count, T_world_vehicle, sensor_index, part, has_point_times)

// At least so long apart, so that no motion is followed from one part of a drive to the next.
inline constexpr std::int64_t kPauseBetweenParts_ns = 60'000'000'000;

// A recording after ingest: scans in order of time. Scans of two sensors may have the same time;
// the sensor listed first then comes first. Several drives of one vehicle may be one (join-drives):
// its parts follow each other in time, a minute and more apart.
struct Drive {
  std::string name;
  SensorProfile sensor;  // the first; the one that localizes
  std::vector<SensorProfile> other_sensors;
  std::vector<std::string> later_parts;  // names of the parts after the first, ascending in time
  MapFrame frame;  // near the first given pose; origin zero where there are no poses
  std::vector<ScanInfo> scans;
  // Ascending in time; empty: nothing measured them.
  std::vector<TurnRate> turn_rates;
  std::vector<SpecificForce> specific_forces;
  std::vector<WheelSpeed> wheel_speeds;
  std::vector<Notice> notices;             // contradictions that were accepted
  std::shared_ptr<const ScanStore> store;  // not encoded; index = position in `scans`

  [[nodiscard]] bool has_poses() const;  // every scan has one
  // The sensor that made a scan: its place in the vehicle, its beams, its ranges.
  [[nodiscard]] const SensorProfile& sensor_of(const ScanInfo& scan) const;
  // What the part of a scan is called; of a drive of one part its own name.
  [[nodiscard]] const std::string& name_of_part(std::uint32_t part) const;
  [[nodiscard]] std::string names_of_parts() const;  // "monday, tuesday"
};
SIGHTLINE_SOME_FIELDS(Drive, name, sensor, other_sensors, later_parts, frame, scans, turn_rates,
                      specific_forces, wheel_speeds, notices)

template <>
struct ArtifactTraits<Drive> {
  static constexpr std::string_view kName = "drive";
  static constexpr std::uint32_t kVersion = 5;
  static constexpr bool kRefersOutside = true;  // the store
};

// Which scans of a recording a pass uses, by recording_index.
enum class ScanSelection : std::uint8_t { kAll, kEven, kOdd };
template <>
inline constexpr auto kNamesOf<ScanSelection> = enum_names("all", "even", "odd");
bool is_selected(const ScanInfo& scan, ScanSelection selection);

Result<void> validate(const Drive& drive);  // says nothing about the store
Table dump(const Drive& drive);

// The drive with its scans behind it, for example after decode, which leaves it without.
Drive with_store(Drive drive, std::shared_ptr<const ScanStore> store);

}  // namespace sightline
