#include "passes/localize/track_drive.h"

#include <algorithm>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/stopwatch.h"
#include "passes/localize/track_matcher.h"
#include "passes/matching/localizer.h"
#include "passes/matching/match_starts.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

// Scans that are read before all replays go on over them: a second of driving.
constexpr std::size_t kScansInBlock = 16;

// What all replays share.
struct Setup {
  const TrackDriveOptions& options;
  const DriveOnMap& placed;
  const std::vector<double>& limits_m;
  const Localizer& localizer;
  const std::vector<InitialOffset>& offsets;
};

// A scan in memory, and where it truly was.
struct KnownScan {
  Scan scan;
  Pose T_map_reference = Pose::Identity();
  bool follows = false;  // on the scan before it: no gap in time or on the map
};

// One replay between two scans.
struct Replay {
  TrackRule rule;
  TrackMatcher matcher;
  std::size_t begun_count = 0;
  int result_count = 0;                   // in a row since the track began; 0: not on track
  Pose T_map_last = Pose::Identity();     // as found
  Pose T_before_last = Pose::Identity();  // the motion that led there, in the vehicle's frame
  std::int64_t last_step_ns = 0;          // how long it took
  std::vector<TrackStep> steps;
};

// From outside, as a satellite receiver and the wheels would tell it: the next start of the
// measured set, and the speed of the step before.
Pose begin_track(const Setup& setup, const KnownScan& now, const KnownScan* before,
                 Replay& replay) {
  const InitialOffset& offset = setup.offsets[replay.begun_count++ % setup.offsets.size()];
  replay.T_before_last = Pose::Identity();
  if (before != nullptr && now.follows) {
    replay.T_before_last = before->T_map_reference.inverse(Eigen::Isometry) * now.T_map_reference;
  }
  replay.result_count = 0;
  return now.T_map_reference * start_pose(offset);
}

Pose prediction(const Replay& replay, std::int64_t this_step_ns) {
  const double factor = replay.last_step_ns > 0 ? static_cast<double>(this_step_ns) /
                                                      static_cast<double>(replay.last_step_ns)
                                                : 1.0;
  return predicted_pose(replay.T_map_last, replay.T_before_last, factor);
}

void follow_scan(const Setup& setup, std::size_t position, const KnownScan& now,
                 const KnownScan* before, Replay& replay) {
  TrackStep step;
  const std::int64_t this_step_ns = setup.placed.step_ns(position);
  const bool goes_on = replay.result_count > 0 && now.follows;
  const Pose T_map_start =
      goes_on ? prediction(replay, this_step_ns) : begin_track(setup, now, before, replay);
  const double begin_ms = thread_cpu_ms();
  const TrackMatcher::Found found =
      replay.matcher.match(now.scan, {T_map_start, replay.result_count > 1});
  step.time_ms = thread_cpu_ms() - begin_ms;
  const Pose& T_map_found = found.match.T_map_sensor;
  step.range_m = found.range_m;
  step.work = static_cast<double>(found.match.work);
  step.error_m = (T_map_found.translation() - now.T_map_reference.translation()).norm();
  if (found.took_second) step.flags |= kTrackSecondLook;
  if (goes_on) {
    replay.T_before_last = replay.T_map_last.inverse(Eigen::Isometry) * T_map_found;
  } else {
    step.flags |= kTrackBegins;
  }
  ++replay.result_count;
  replay.last_step_ns = this_step_ns;
  replay.T_map_last = T_map_found;
  if (step.error_m > setup.options.lost_beyond_m) {
    step.flags |= kTrackLost;
    replay.result_count = 0;
  }
  replay.steps.push_back(step);
}

// The scan at a position among those on the map.
Result<KnownScan> known_scan(const Setup& setup, std::size_t position) {
  const Drive& drive = setup.placed.drive;
  const std::size_t index = setup.placed.scans[position];
  SIGHTLINE_ASSIGN(Scan scan, drive.store->read(index));
  KnownScan known;
  known.T_map_reference = setup.placed.in_map.poses[index].T_map_vehicle;
  if (setup.options.matching.reference != ErrorReference::kKnownPose) {
    ScanCutter cutter;
    ScanForMatch full =
        make_scan_for_match(setup.localizer, cutter, scan, drive.sensor,
                            {drive.sensor.max_range_m, setup.options.matching.leaf_m,
                             setup.options.matching.every_return});
    known.T_map_reference = localize(setup.localizer, full, known.T_map_reference).T_map_sensor;
  }
  known.scan = std::move(scan);
  const bool is_even_step = setup.options.matching.scans == ScanSelection::kAll;
  const std::size_t next = is_even_step ? 1 : 2;  // in the recording
  known.follows = position > 0 && index - setup.placed.scans[position - 1] <= next &&
                  setup.placed.step_ns(position) <= kLongestStep_ns;
  return known;
}

// Replays of the block that begins at `first`; `before` is the scan before it, or null.
Result<KnownScan> follow_block(const PassContext& ctx, const Setup& setup, std::size_t first,
                               const KnownScan* before, std::vector<Replay>& replays) {
  const std::size_t count = std::min(kScansInBlock, setup.placed.scans.size() - first);
  std::vector<KnownScan> known(count);
  std::vector<std::optional<Error>> failures(count);
  parallel_for(count, ctx.threads, [&](std::size_t i) {
    Result<KnownScan> scan = known_scan(setup, first + i);
    if (scan) {
      known[i] = std::move(*scan);
    } else {
      failures[i] = scan.error();
    }
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  parallel_for(replays.size(), ctx.threads, [&](std::size_t r) {
    for (std::size_t i = 0; i < count; ++i) {
      follow_scan(setup, first + i, known[i], i == 0 ? before : &known[i - 1], replays[r]);
    }
  });
  return std::move(known.back());
}

std::vector<Replay> replays_of(const TrackInputs& inputs) {
  std::vector<Replay> replays;
  for (const TrackRule& rule : track_rules(inputs.ranges)) {
    replays.push_back({.rule = rule, .matcher = TrackMatcher(inputs, rule), .steps = {}});
  }
  return replays;
}

DriveTracks to_tracks(const Setup& setup, const std::vector<Replay>& replays) {
  const DriveOnMap& placed = setup.placed;
  DriveTracks tracks;
  tracks.drive = placed.drive.name;
  tracks.reference = setup.options.matching.reference;
  tracks.lost_beyond_m = setup.options.lost_beyond_m;
  tracks.limits_m = setup.limits_m;
  for (const std::size_t scan : placed.scans) {
    const Eigen::Vector3d p_map_m = placed.sensor_m(placed.in_map.poses[scan].T_map_vehicle);
    tracks.scans.push_back({placed.drive.scans[scan].recording_index, p_map_m.x(), p_map_m.y()});
  }
  for (const Replay& replay : replays) {
    tracks.rules.push_back(replay.rule);
    tracks.steps.insert(tracks.steps.end(), replay.steps.begin(), replay.steps.end());
  }
  return tracks;
}

}  // namespace

std::vector<OptionField> option_fields(TrackDriveOptions& options) {
  return with_matching(
      {number("lost_beyond_m", options.lost_beyond_m,
              "continuous localization: a track is lost above this error, m", 0.01, 100.0),
       reach_option(options.reach_m)},
      options.matching);
}

Result<DriveTracks> track_drive(PassContext& ctx, const TrackDriveOptions& wanted,
                                const Drive& drive, const Trajectory& trajectory,
                                const TiledNds& nds, const Sites& sites,
                                const ByFamily<RangeTable>& ranges) {
  SIGHTLINE_ASSIGN(DriveOnMap placed, place_on_map(drive, trajectory, nds, sites, ranges.ranges,
                                                   wanted.reach_m, wanted.matching.scans));
  std::erase_if(placed.scans, [&](std::size_t scan) {
    return !placed.site_near(placed.in_map.poses[scan].T_map_vehicle);
  });
  // A vehicle that got lost may be anywhere on the map.
  SIGHTLINE_ASSIGN(const NdtMap map, nds.whole());
  TrackDriveOptions options = wanted;
  options.matching.reference = reference_of(wanted.matching, trajectory);
  if (placed.scans.empty()) {
    return Error{ErrorCode::kNoOverlap, concat("drive '", drive.name, "' has no scan within ",
                                               format_double(options.reach_m), " m of any of ",
                                               sites.sites.size(), " sites")};
  }
  const MeasureErrorOptions& matching = options.matching;
  const Localizer localizer =
      make_localizer(map, localizer_options(matching.localizer, matching.coarse_cells));
  const Localizer of_samples = ranges.samples
                                   ? make_localizer(map, options_for_samples(matching.coarse_cells))
                                   : Localizer{};
  const std::vector<InitialOffset> offsets = initial_offsets(starts_of(matching));
  std::vector<double> limits_m;
  for (const LimitPromise& promise : ranges.ranges.promises) limits_m.push_back(promise.limit_m);
  const Setup setup{options, placed, limits_m, localizer, offsets};
  std::vector<Replay> replays =
      replays_of({placed, ranges, localizer, of_samples, matching.leaf_m, matching.every_return});
  KnownScan before;
  const std::size_t count = placed.scans.size();
  for (std::size_t first = 0; first < count; first += kScansInBlock) {
    SIGHTLINE_ASSIGN(KnownScan last,
                     follow_block(ctx, setup, first, first == 0 ? nullptr : &before, replays));
    before = std::move(last);
    ctx.progress(std::min(first + kScansInBlock, count), count);
  }
  return to_tracks(setup, replays);
}

}  // namespace sightline
