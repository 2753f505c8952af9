#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"
#include "passes/matching/match_score.h"
#include "passes/replay/joined_maps.h"

// What a replay takes, and what it finds of each scan.

namespace sightline {

// A scan of a recording, before it is read.
struct ListedScan {
  std::int64_t stamp_ns = 0;
  std::string name;                     // for messages
  std::optional<Pose> T_world_vehicle;  // where the recording has poses; used to start alone
};

struct ReplayOptions {
  std::optional<Pose> T_world_start;     // of the first scan; else poses of the recording
  bool starts_from_nothing = false;      // poses of the recording are not used
  double limit_m = 0.10;                 // of errors, for which maps answer; 0: each its tightest
  std::optional<double> every_return_m;  // match all returns within this, whatever the map names
};

// What a vehicle has. A replay changes which map is the present one.
struct ReplayInputs {
  JoinedMaps& maps;
  const SensorProfile& sensor;
  const ScanStore& store;
  const std::vector<ListedScan>& scans;  // by number in the store; times ascend
};

enum class ScanState : std::uint8_t { kLocalized, kLost, kSkipped };
template <>
inline constexpr auto kNamesOf<ScanState> = enum_names("localized", "lost", "skipped");

struct ReplayedScan {
  ScanState state = ScanState::kSkipped;
  // Localized, but by the plan's second look, or where the scan was found to contradict the map.
  bool is_in_doubt = false;
  bool begins = false;   // found from outside: at the start, after a pause, after it was lost
  bool has_pose = true;  // false: lost, and without a pose before it
  // Where localized; where lost, the pose that the last ones predict, which is not known.
  Pose T_world_vehicle = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  // of the match (sightline_match)
  MapLook look;                            // whose match is the pose
  int look_count = 0;
  std::uint32_t point_count = 0;  // that were matched
  std::uint32_t weak = 0;         // SIGHTLINE_WEAK_*
  // CPU time of all threads, without reading the scan or, but for a search, a map; differs between
  // runs
  double time_ms = 0.0;
  std::size_t map = 0;  // of those that are joined, which this scan was localized or lost in
};

}  // namespace sightline
