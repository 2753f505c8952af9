#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/evaluation/trajectory_errors.h"
#include "formats/text/table.h"
#include "passes/replay/replay_drive.h"

// What `sightline localize` found, for people and for programs.

namespace sightline {

// Scans in a row that were lost, or localized in doubt.
struct DoubtfulStretch {
  bool is_lost = false;
  std::size_t first = 0;  // numbers of scans
  std::size_t last = 0;
  Eigen::Vector3d first_world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d last_world_m = Eigen::Vector3d::Zero();
  bool has_place = true;  // false: lost before anything was found, the positions mean nothing
  [[nodiscard]] std::size_t scan_count() const { return last - first + 1; }
};

struct ReplayFigures {
  std::size_t scan_count = 0;
  std::size_t localized_count = 0;  // in doubt or not
  std::size_t doubtful_count = 0;
  std::size_t second_look_count = 0;  // of these, by the plan's second look
  std::size_t lost_scan_count = 0;
  std::size_t skipped_count = 0;  // could not be read
  std::size_t lost_count = 0;     // times that it was lost after it had been localized
  double duration_s = 0.0;
  double period_ms = 0.0;  // median time between scans
  double median_ms = 0.0;  // CPU time of a scan, without reading it
  double p99_ms = 0.0;
  std::vector<DoubtfulStretch> stretches;  // in the order of the scans
};
// Scans and what was found of each.
ReplayFigures figures_of(const std::vector<ListedScan>& scans, const ReplayedDrive& drive);

// A comparison with other poses, and how it was made.
struct ComparedPoses {
  std::string file;
  TrajectoryErrorOptions options;
  TrajectoryErrors errors;
};

// A map of the drive.
struct UsedMap {
  std::string file;
  std::size_t localized_count = 0;  // scans that were localized in it
  std::optional<Error> fault;       // why it could not be read
};
std::vector<UsedMap> maps_of(const JoinedMaps& maps, const ReplayedDrive& drive);

struct ReplayReport {
  std::string drive;
  std::vector<UsedMap> maps;
  ReplayFigures figures;
  std::optional<ComparedPoses> compared;
};

// Four lines, a fifth of several maps and, with a comparison, its table. Names the five longest
// stretches.
std::string to_text(const ReplayReport& report);

// As schemas/localize.schema.json describes it.
std::string to_json(const ReplayReport& report);

}  // namespace sightline
