#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"

// A drive replayed as a vehicle lives it: each pose starts from what the poses found before
// foretell (schemas/definitions.md, "Continuous localization"). One replay for each way to choose
// the range.
//
// Times are CPU times and differ from run to run; work (points x iterations) does not.

namespace sightline {

// Who chooses the range of a replay: the map for a limit, or nobody.
struct TrackRule {
  double limit_m = 0.0;         // of the map's ranges; 0 where the range is static
  double static_range_m = 0.0;  // 0 where the map chooses

  [[nodiscard]] bool is_static() const { return static_range_m > 0.0; }
};

struct TrackedScan {
  std::uint32_t recording_index = 0;
  double p_x_map_m = 0.0;  // the sensor's origin at the reference pose
  double p_y_map_m = 0.0;
};

// Flags of a step.
inline constexpr std::uint8_t kTrackBegins = 1;  // started from outside
inline constexpr std::uint8_t kTrackLost = 2;    // ended too far off: the next step begins anew

// One scan in one replay.
struct TrackStep {
  double range_m = 0.0;
  double error_m = 0.0;  // 3D distance from the reference
  double time_ms = 0.0;  // crop, subsample and match, one thread
  double work = 0.0;
  std::uint8_t flags = 0;
};

struct DriveTracks {
  std::string drive;
  ErrorReference reference = ErrorReference::kKnownPose;
  double lost_beyond_m = 0.0;
  std::vector<double> limits_m;  // ascending
  std::vector<TrackRule> rules;  // the map's for each limit, then static ranges, ascending
  std::vector<TrackedScan> scans;
  std::vector<TrackStep> steps;  // [rule][scan]

  [[nodiscard]] const TrackStep& step(std::size_t rule, std::size_t scan) const {
    return steps[rule * scans.size() + scan];
  }
};

// One replay at one limit. Ratios are to the longest static range.
struct TrackScore {
  double coverage = 0.0;  // share of scans with an error of at most the limit, lost ones included
  double mean_error_m = 0.0;
  double p95_error_m = 0.0;  // linear interpolation
  double max_error_m = 0.0;
  double mean_range_m = 0.0;
  double time_ratio = 0.0;
  double work_ratio = 0.0;
  double mean_time_ms = 0.0;
  std::uint32_t track_count = 0;
  std::uint32_t lost_count = 0;
};
TrackScore score_track(const DriveTracks& tracks, std::size_t rule, double limit_m);

template <>
struct ArtifactTraits<DriveTracks> {
  static constexpr std::string_view kName = "drive-tracks";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const DriveTracks& tracks);
Table dump(const DriveTracks& tracks);  // scores: the map's at their limits, static ones at each
// "continuous-localization" and "continuous-localization-scans"
// (schemas/evaluation.schema.json).
std::vector<Table> tables(const DriveTracks& tracks);
void encode(const DriveTracks& tracks, ByteWriter& writer);
void decode(ByteReader& reader, DriveTracks& tracks);

// For people: a table for each limit.
std::string to_text(const DriveTracks& tracks);

}  // namespace sightline
