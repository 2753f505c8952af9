#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/record/fields.h"

// A drive replayed as a vehicle lives it: each pose starts from what the poses found before
// predict (schemas/definitions.md, "Continuous localization"). One replay for each way to choose
// how to look. Times are CPU times and differ from run to run; work (points x iterations) does not.

namespace sightline {

// Who chooses.
enum class TrackChoice : std::uint8_t {
  kRange,  // the map its observation range, for a limit
  kLook,   // the map its look, for a limit, searching at every scan
  kPlan,   // the map its plan: a cheap look, and a dearer one where a test doubts it
  kNobody  // the same is taken everywhere
};
template <>
inline constexpr auto kNamesOf<TrackChoice> = enum_names("map", "look", "plan", "static");

struct TrackRule {
  TrackChoice choice = TrackChoice::kNobody;
  double limit_m = 0.0;  // that the map chooses for; 0 where there is no choice
  Look look;             // without a choice: what is taken everywhere

  [[nodiscard]] bool is_static() const { return choice == TrackChoice::kNobody; }
  // 0 where the map chooses.
  [[nodiscard]] double static_range_m() const { return is_static() ? look.range_m : 0.0; }
};
SIGHTLINE_FIELDS(TrackRule, choice, limit_m, look)

// Static ones are judged at any limit, the map's at that which it chooses for.
bool is_judged_at(const TrackRule& rule, double limit_m);

std::string name_of(const TrackRule& rule);  // for people

struct TrackedScan {
  std::uint32_t recording_index = 0;
  double p_x_map_m = 0.0;  // the sensor's origin at the reference pose
  double p_y_map_m = 0.0;
};
SIGHTLINE_FIELDS(TrackedScan, recording_index, p_x_map_m, p_y_map_m)

// Flags of a step.
inline constexpr std::uint8_t kTrackBegins = 1;      // started from outside
inline constexpr std::uint8_t kTrackLost = 2;        // ended too far off: the next step begins anew
inline constexpr std::uint8_t kTrackSecondLook = 4;  // the plan's test doubted the first look

// One scan in one replay.
struct TrackStep {
  double range_m = 0.0;
  double error_m = 0.0;  // 3D distance from the reference
  double time_ms = 0.0;  // crop, subsample and match, one thread
  double work = 0.0;
  std::uint8_t flags = 0;
};
SIGHTLINE_FIELDS(TrackStep, range_m, error_m, time_ms, work, flags)

struct DriveTracks {
  std::string drive;
  ErrorReference reference = ErrorReference::kKnownPose;
  double lost_beyond_m = 0.0;
  std::vector<double> limits_m;  // ascending
  // As TrackChoice orders them: the map's range for each limit; its look for each, where it has
  // looks; its plan for those that may go by it; static looks, of which those that take every
  // return come last and ascend.
  std::vector<TrackRule> rules;
  std::vector<TrackedScan> scans;
  std::vector<TrackStep> steps;  // [rule][scan]

  [[nodiscard]] const TrackStep& step(std::size_t rule, std::size_t scan) const {
    return steps[rule * scans.size() + scan];
  }
};
SIGHTLINE_FIELDS(DriveTracks, drive, reference, lost_beyond_m, limits_m, rules, scans, steps)

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
  double second_share = 0.0;  // of scans at which a second look followed
};
SIGHTLINE_FIELDS(TrackScore, coverage, mean_error_m, p95_error_m, max_error_m, mean_range_m,
                 time_ratio, work_ratio, mean_time_ms, track_count, lost_count, second_share)
TrackScore score_track(const DriveTracks& tracks, std::size_t rule, double limit_m);
SIGHTLINE_ARTIFACT(DriveTracks, "drive-tracks", 3)

Result<void> validate(const DriveTracks& tracks);
Table dump(const DriveTracks& tracks);  // scores: the map's at their limits, static ones at each
// "continuous-localization" and "continuous-localization-scans"
// (schemas/evaluation.schema.json).
std::vector<Table> tables(const DriveTracks& tracks);

// For people: a table for each limit.
std::string to_text(const DriveTracks& tracks);

}  // namespace sightline
