#include "passes/ingest/ingest.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/units.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/point_times.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/text/numbers.h"
#include "passes/ingest/check_frame.h"
#include "passes/ingest/check_pose_clock.h"
#include "passes/ingest/check_sensor.h"
#include "passes/ingest/check_upright.h"
#include "passes/ingest/odd_scans.h"
#include "passes/ingest/pose_reading.h"
#include "passes/ingest/top_view.h"

namespace sightline {
namespace {

// What one scan's file says, without its points.
struct ScanCounts {
  std::uint64_t point_count = 0;
  std::uint64_t nonfinite_count = 0;
  std::uint64_t zero_count = 0;
  std::uint64_t withheld_count = 0;
  bool may_be_cut = false;
  bool is_far_away = false;  // most points are farther than any LiDAR sees
  bool has_point_times = false;
  bool has_unclear_times = false;
  SettledTimes times;
  std::string unread_time;
};

ScanCounts count(PointCloudFile cloud, const RecordedScan& scan, std::int64_t step_ns) {
  // Farther than any LiDAR sees: then these are no coordinates of the sensor.
  constexpr double kFarthest_m = 2000.0;
  const SettledTimes times = settle_point_times(scan.stamp_ns, step_ns, cloud);
  const auto far_points = std::ranges::count_if(cloud.points_m, [](const Eigen::Vector3d& point_m) {
    return point_m.squaredNorm() > kFarthest_m * kFarthest_m;
  });
  return {.point_count = cloud.points_m.size(),
          .nonfinite_count = cloud.nonfinite_count,
          .zero_count = cloud.zero_count,
          .withheld_count = cloud.withheld_count,
          .may_be_cut = cloud.may_be_cut,
          .is_far_away = 2 * static_cast<std::size_t>(far_points) > cloud.points_m.size(),
          .has_point_times = !cloud.time_offset_ns.empty(),
          .has_unclear_times = cloud.has_unclear_times,
          .times = times,
          .unread_time = cloud.unread_time};
}

Result<void> check_times(const Recording& recording) {
  for (std::size_t i = 1; i < recording.scans.size(); ++i) {
    const std::int64_t before_ns = recording.scans[i - 1].stamp_ns;
    if (recording.scans[i].stamp_ns > before_ns) continue;
    return Error{
        ErrorCode::kTimeRunsBackwards,
        concat("found time ", format_stamp(recording.scans[i].stamp_ns), " s, expected one after ",
               format_stamp(before_ns), " s of ", recording.scans[i - 1].name),
        recording.file_of(recording.scans[i]).string(), concat("scan ", i)};
  }
  return {};
}

// A pause in the recording: a step far longer than the usual one and than a scan.
void warn_of_gaps(const PassContext& ctx, const Recording& recording) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < recording.scans.size(); ++i) {
    steps_ns.push_back(recording.scans[i].stamp_ns - recording.scans[i - 1].stamp_ns);
  }
  if (steps_ns.empty()) return;
  std::vector<std::int64_t> sorted_ns = steps_ns;
  const auto middle = sorted_ns.begin() + static_cast<std::ptrdiff_t>(sorted_ns.size() / 2);
  std::ranges::nth_element(sorted_ns, middle);
  const std::int64_t least_ns = std::max(kSecond_ns, 3 * *middle);
  const auto is_gap = [&](std::int64_t step_ns) { return step_ns > least_ns; };
  const auto first = std::ranges::find_if(steps_ns, is_gap);
  if (first == steps_ns.end()) return;
  const auto before = static_cast<std::size_t>(first - steps_ns.begin());
  ctx.warn(fmt::format(
      "drive {}: {} gaps in time, the first of {} s between scan {} ({}) and scan {} ({})",
      recording.name, std::ranges::count_if(steps_ns, is_gap), format_stamp(*first), before,
      recording.scans[before].name, before + 1, recording.scans[before + 1].name));
}

// Stops early after a failure, and still reports the same one for any number of threads: that of
// the lowest index, since a scan is skipped only behind a known failure.
struct CountedScans {
  std::vector<ScanCounts> counts;
  std::vector<TopView> views;
  std::vector<bool> is_empty;
  std::optional<Error> first_empty;  // why it cannot be read
};

Result<CountedScans> count_all(PassContext& ctx, const Recording& recording) {
  const std::size_t total = recording.scans.size();
  const std::int64_t step_ns = usual_step_ns(recording.scans);
  std::vector<ScanCounts> counts(total);
  std::vector<TopView> views(total);
  std::vector<std::optional<Error>> failures(total);
  std::atomic<std::size_t> first_failure = total;
  std::atomic<std::size_t> done = 0;
  parallel_for(total, ctx.threads, [&](std::size_t i) {
    if (i > first_failure.load()) return;
    Result<PointCloudFile> cloud = read_recorded_scan(recording, i);
    if (cloud) {
      views[i] = TopView(*cloud, recording.sensor);
      counts[i] = count(*std::move(cloud), recording.scans[i], step_ns);
    } else {
      failures[i] = cloud.error();
      if (is_without_returns(cloud.error())) return;
      std::size_t known = first_failure.load();
      while (i < known && !first_failure.compare_exchange_weak(known, i)) {
      }
    }
    ctx.progress(done.fetch_add(1) + 1, total);
  });
  if (first_failure.load() < total) return *failures[first_failure.load()];
  CountedScans counted{std::move(counts), std::move(views), std::vector<bool>(total, false), {}};
  for (std::size_t i = 0; i < total; ++i) {
    if (failures[i] && !counted.first_empty) counted.first_empty = failures[i];
    counted.is_empty[i] = failures[i].has_value();
  }
  return counted;
}

template <class Of>
void leave_out(const std::vector<bool>& is_odd, std::vector<Of>& of_scans) {
  std::vector<Of> kept;
  for (std::size_t i = 0; i < of_scans.size(); ++i) {
    if (!is_odd[i]) kept.push_back(std::move(of_scans[i]));
  }
  of_scans = std::move(kept);
}

void leave_out(const std::vector<bool>& is_odd, Recording& recording, CountedScans& counted) {
  leave_out(is_odd, recording);
  leave_out(is_odd, counted.counts);
  leave_out(is_odd, counted.views);
}

// The recording without scans that have no returns, where these are few. Error: that of the first.
Result<Recording> without_empty(const PassContext& ctx, Recording recording,
                                CountedScans& counted) {
  const auto empty = static_cast<std::size_t>(std::ranges::count(counted.is_empty, true));
  if (empty == 0) return recording;
  if (!are_few(empty, recording.scans.size())) return *counted.first_empty;
  ctx.warn(concat(
      "drive ", recording.name, ": ", empty, " of ", recording.scans.size(),
      " scans have no returns and are left out: ", names_of_odd(counted.is_empty, recording)));
  leave_out(counted.is_empty, recording, counted);
  return recording;
}

// The recording without scans that contradict their neighbours, where these are few.
Result<Recording> without_odd(const PassContext& ctx, Recording recording, CountedScans& counted) {
  const std::vector<bool> is_odd =
      odd_scans(counted.views, level_sensor_poses(recording), ctx.threads);
  const auto odd = static_cast<std::size_t>(std::ranges::count(is_odd, true));
  if (odd == 0) return recording;
  const std::string which =
      concat(odd, " of ", recording.scans.size(),
             " scans do not fit the scans before and after them, which fit each other: ",
             names_of_odd(is_odd, recording));
  if (!are_few(odd, recording.scans.size())) {
    return Error{ErrorCode::kMismatchedInputs,
                 concat(which,
                        ". Up to 5 % are left out. These may be turned, or scans of another "
                        "place or sensor: remove them"),
                 recording.source.string(), "drive " + recording.name};
  }
  ctx.warn(concat("drive ", recording.name, ": ", which, ". They are left out"));
  leave_out(is_odd, recording, counted);
  return recording;
}

// Then these are no coordinates of the sensor in metres, and no map of them is right.
Result<void> check_reach(const Recording& recording, const std::vector<ScanCounts>& counts) {
  const auto far_scans = std::ranges::count_if(counts, &ScanCounts::is_far_away);
  if (2 * static_cast<std::size_t>(far_scans) <= counts.size()) return {};
  const auto first = std::ranges::find_if(counts, &ScanCounts::is_far_away);
  const auto index = static_cast<std::size_t>(first - counts.begin());
  return Error{
      ErrorCode::kUnsupportedFormat,
      fmt::format(
          "most points of {} of {} scans are farther than 2 km, beyond the reach of a LiDAR. "
          "Expected metres in the sensor's frame; these look like world coordinates or millimetres",
          far_scans, counts.size()),
      recording.file_of(recording.scans[index]).string(), concat("scan ", index)};
}

std::string seconds(std::int64_t time_ns) {
  return format_double(std::round(static_cast<double>(time_ns) / 1e6) / 1e3) + " s";
}

std::int64_t median(std::vector<std::int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Of the scans with times of this kind, as count and median of a member.
struct TimesOfKind {
  std::size_t count = 0;
  std::int64_t span_ns = 0;
  std::int64_t ahead_ns = 0;
};

TimesOfKind times_of_kind(const std::vector<ScanCounts>& counts, PointTimesKind kind) {
  std::vector<std::int64_t> spans_ns;
  std::vector<std::int64_t> ahead_ns;
  for (const ScanCounts& scan : counts) {
    if (scan.times.kind != kind) continue;
    spans_ns.push_back(scan.times.span_ns);
    ahead_ns.push_back(scan.times.ahead_ns);
  }
  if (spans_ns.empty()) return {};
  return {spans_ns.size(), median(spans_ns), median(ahead_ns)};
}

void warn_of_times(const PassContext& ctx, const Recording& recording,
                   const std::vector<ScanCounts>& counts) {
  // Clocks farther apart count from different events; their times are known not to be the stamps'.
  constexpr std::int64_t kSameEpoch_ns = 3600 * kSecond_ns;
  const std::string drive = concat("drive ", recording.name, ": ");
  const std::string step = seconds(usual_step_ns(recording.scans));
  const TimesOfKind shares = times_of_kind(counts, PointTimesKind::kShares);
  if (shares.count > 0) {
    ctx.warn(concat(drive, "the point times of ", shares.count,
                    " scans are from 0 to 1, but scans are ", step,
                    " apart; they are read as shares of a sweep of ", step));
  }
  const TimesOfKind longer = times_of_kind(counts, PointTimesKind::kTooLong);
  if (longer.count > 0) {
    ctx.warn(concat(drive, "the point times of ", longer.count, " scans span ",
                    seconds(longer.span_ns), ", but scans are ", step,
                    " apart; these times are ignored, and motion within these scans is not "
                    "removed"));
  }
  const TimesOfKind other = times_of_kind(counts, PointTimesKind::kOtherClock);
  if (other.count > 0 && std::abs(other.ahead_ns) < kSameEpoch_ns) {
    ctx.warn(concat(drive, "the point times of ", other.count, " scans begin ",
                    seconds(std::abs(other.ahead_ns)), other.ahead_ns < 0 ? " before" : " after",
                    " the times of the scans, so they are of another clock; they are counted from "
                    "the time of each scan"));
  }
  const auto unread = std::ranges::find_if(
      counts, [](const ScanCounts& scan) { return !scan.unread_time.empty(); });
  if (unread != counts.end()) {
    ctx.warn(concat(drive, "the field `", unread->unread_time,
                    "` of the scans may contain times of points, but is not a known name and is "
                    "not read; rename it to `timestamp` if so"));
  }
}

void warn_of(const PassContext& ctx, const Recording& recording,
             const std::vector<ScanCounts>& counts) {
  for (const std::string& warning : recording.warnings) ctx.warn(warning);
  for (const std::string& remark : recording.remarks) {
    ctx.inform(concat("drive ", recording.name, ": ", remark));
  }
  ScanCounts sum;
  for (const ScanCounts& scan : counts) {
    sum.point_count += scan.point_count;
    sum.nonfinite_count += scan.nonfinite_count;
    sum.zero_count += scan.zero_count;
    sum.withheld_count += scan.withheld_count;
  }
  const std::string drive = concat("drive ", recording.name, ": ");
  if (sum.nonfinite_count + sum.zero_count > 0) {
    ctx.inform(fmt::format("{}dropped {} NaN or infinite points and {} at (0,0,0), kept {}", drive,
                           sum.nonfinite_count, sum.zero_count, sum.point_count));
  }
  if (sum.withheld_count > 0) {
    ctx.inform(fmt::format("{}dropped {} points that their files mark as withheld, kept {}", drive,
                           sum.withheld_count, sum.point_count));
  }
  const auto warn_of_some = [&](bool ScanCounts::*is_so, const char* what) {
    const auto scans = std::ranges::count_if(counts, is_so);
    if (scans > 0) ctx.warn(concat(drive, scans, what));
  };
  warn_of_some(&ScanCounts::may_be_cut,
               " text scans have no line end in the last line; their last number may be cut off");
  warn_of_some(&ScanCounts::is_far_away,
               " scans have most of their points farther than 2 km, beyond the reach of a LiDAR");
  warn_of_some(&ScanCounts::has_unclear_times,
               " scans have point times that do not span 2 ms to 2 s in any unit, or fewer than 16 "
               "different ones; these times are ignored, and motion within these scans is not "
               "removed");
  warn_of_times(ctx, recording, counts);
  warn_of_gaps(ctx, recording);
}

std::vector<ScanInfo> describe(const Recording& recording, const std::vector<ScanCounts>& counts) {
  std::vector<ScanInfo> scans;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const RecordedScan& recorded = recording.scans[i];
    ScanInfo& scan = scans.emplace_back();
    scan.recording_index = recorded.index;
    scan.stamp_ns = recorded.stamp_ns;
    scan.source = recorded.name;
    scan.point_count = counts[i].point_count;
    scan.nonfinite_count = counts[i].nonfinite_count;
    scan.zero_count = counts[i].zero_count;
    scan.T_world_vehicle = recorded.T_world_vehicle;
    scan.has_point_times = counts[i].has_point_times;
  }
  return scans;
}

}  // namespace

Result<Drive> ingest(PassContext& ctx, const IngestOptions& options, const Recording& opened) {
  if (opened.scans.empty()) {
    return Error{ErrorCode::kDriveTooShort, concat("drive ", opened.name, " has no scans")};
  }
  SIGHTLINE_TRY(check_times(opened));
  SIGHTLINE_ASSIGN(CountedScans counted, count_all(ctx, opened));
  SIGHTLINE_ASSIGN(Recording recording, without_empty(ctx, opened, counted));
  warn_of(ctx, recording, counted.counts);
  SIGHTLINE_TRY(check_reach(recording, counted.counts));
  SIGHTLINE_TRY(check_frame(recording));
  SIGHTLINE_TRY(check_pose_clock(recording));
  SIGHTLINE_ASSIGN(recording, without_odd(ctx, std::move(recording), counted));
  Drive drive;
  SIGHTLINE_TRY(check_sensor(ctx, recording, drive.notices));
  drive.name = recording.name;
  drive.sensor = recording.sensor;
  drive.scans = describe(recording, counted.counts);
  drive.turn_rates = recording.turn_rates;
  drive.specific_forces = recording.specific_forces;
  drive.wheel_speeds = recording.wheel_speeds;
  SIGHTLINE_TRY(try_w_first(ctx, recording, drive));
  SIGHTLINE_TRY(check_upright(recording, drive));
  if (drive.has_poses()) {
    const Eigen::Vector3d first_m = drive.scans.front().T_world_vehicle->translation();
    drive.frame = frame_near(first_m, options.tile_m);
  }
  return with_store(std::move(drive), recorded_scan_store(recording));
}

void reattach(Drive& drive, const Recording& recording) {
  std::set<std::uint32_t> used;
  for (const ScanInfo& scan : drive.scans) used.insert(scan.recording_index);
  Recording kept = recording;
  std::erase_if(kept.scans, [&](const RecordedScan& scan) { return !used.contains(scan.index); });
  drive.store = recorded_scan_store(kept);
}

}  // namespace sightline
