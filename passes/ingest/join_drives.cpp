#include "passes/ingest/join_drives.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "formats/base/units.h"
#include "formats/drive/scan_stores.h"
#include "formats/foreign/text/pose_file.h"

namespace sightline {
namespace {

// Times below are counted from the beginning of a recording; no clock of a vehicle shows 1973.
constexpr std::int64_t kEarliestClock_ns = 100'000'000'000'000'000;

// What is the matter with its sensor; empty: it is that of `drive`.
std::string difference_of_sensors(const SensorProfile& first, const SensorProfile& later) {
  if (later.name != first.name) return concat("its sensor is ", later.name, ", not ", first.name);
  if (to_bytes(later) == to_bytes(first)) return "";
  return "its sensor has another mounting on the vehicle, or other beams";
}

// By how much the times of `later` are moved.
std::int64_t moved_ns(const PassContext& ctx, const Drive& drive, const Drive& later) {
  const std::int64_t least_ns = drive.scans.back().stamp_ns + kPauseBetweenParts_ns;
  const std::int64_t begin_ns = later.scans.front().stamp_ns;
  if (begin_ns >= least_ns) return 0;
  if (begin_ns >= kEarliestClock_ns) {
    const std::uint32_t last_part = drive.scans.back().part;
    ctx.warn(fmt::format(
        "drive {} begins at {} s, before the end of drive {} at {} s, which is listed earlier: its "
        "times are moved by {} s. List the drives in the order of their days",
        later.name, format_stamp(begin_ns), drive.name_of_part(last_part),
        format_stamp(drive.scans.back().stamp_ns), format_stamp(least_ns - begin_ns)));
  }
  return least_ns - begin_ns;
}

// Samples of a sensor beside the LiDAR.
template <class Sample>
void append_moved(const std::vector<Sample>& later, std::int64_t later_ns,
                  std::vector<Sample>& samples) {
  for (Sample sample : later) {
    sample.stamp_ns += later_ns;
    samples.push_back(sample);
  }
}

// `drive` with the scans of one more.
Drive with_part(const PassContext& ctx, const Drive& drive, const Drive& later) {
  if (later.scans.empty()) return drive;
  if (drive.scans.empty()) return later;
  const std::string difference = difference_of_sensors(drive.sensor, later.sensor);
  if (!difference.empty()) {
    ctx.warn(concat("drive ", later.name, " is left out: ", difference));
    return drive;
  }
  Drive joined = drive;
  const bool has_frame = std::ranges::any_of(
      drive.scans, [](const ScanInfo& scan) { return scan.T_world_vehicle.has_value(); });
  if (!has_frame) joined.frame = later.frame;
  joined.later_parts.push_back(later.name);
  const auto part = static_cast<std::uint32_t>(joined.later_parts.size());
  const std::int64_t later_ns = moved_ns(ctx, drive, later);
  const std::uint32_t first_index = 2 * (drive.scans.back().recording_index / 2 + 1);
  std::vector<ScanOrigin> origins;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) origins.push_back({0, i, 0});
  for (std::size_t i = 0; i < later.scans.size(); ++i) {
    ScanInfo& scan = joined.scans.emplace_back(later.scans[i]);
    scan.recording_index += first_index;
    scan.stamp_ns += later_ns;
    scan.part = part;
    origins.push_back({1, i, later_ns});
  }
  joined.notices.insert(joined.notices.end(), later.notices.begin(), later.notices.end());
  append_moved(later.turn_rates, later_ns, joined.turn_rates);
  append_moved(later.specific_forces, later_ns, joined.specific_forces);
  append_moved(later.wheel_speeds, later_ns, joined.wheel_speeds);
  return with_store(std::move(joined),
                    joined_scan_store({drive.store, later.store}, std::move(origins)));
}

constexpr std::int64_t kLongestGap_ns = kSecond_ns;

// Whether two of the ascending stamps, no gap apart, are around a time.
bool is_between(const std::vector<std::int64_t>& stamps_ns, std::int64_t stamp_ns) {
  const auto after = std::ranges::lower_bound(stamps_ns, stamp_ns);
  if (after == stamps_ns.end()) return false;
  if (*after == stamp_ns) return true;
  return after != stamps_ns.begin() && *after - *std::prev(after) <= kLongestGap_ns;
}

Error no_common_time(const Drive& drive, const Drive& other) {
  const auto span = [](const Drive& d) {
    return d.scans.empty() ? std::string("none")
                           : concat(format_stamp(d.scans.front().stamp_ns), " to ",
                                    format_stamp(d.scans.back().stamp_ns), " s");
  };
  return {ErrorCode::kMismatchedInputs,
          concat("no scan of sensor ", other.name, " (", span(other), ") is within the time of ",
                 drive.name, " (", span(drive), "). Record both with the same clock"),
          "", "drive " + drive.name};
}

// `drive` with the scans of one more sensor.
Result<Drive> with_sensor(const PassContext& ctx, const Drive& drive, const Drive& other) {
  std::vector<std::int64_t> stamps_ns;  // of the first sensor
  std::vector<std::pair<ScanInfo, ScanOrigin>> scans;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (drive.scans[i].sensor_index == 0) stamps_ns.push_back(drive.scans[i].stamp_ns);
    scans.emplace_back(drive.scans[i], ScanOrigin{0, i});
  }
  for (std::size_t i = 0; i < other.scans.size(); ++i) {
    if (!is_between(stamps_ns, other.scans[i].stamp_ns)) continue;
    ScanInfo& scan = scans.emplace_back(other.scans[i], ScanOrigin{1, i}).first;
    scan.sensor_index = static_cast<std::uint32_t>(drive.other_sensors.size() + 1);
    scan.T_world_vehicle.reset();
  }
  const std::size_t left_out = drive.scans.size() + other.scans.size() - scans.size();
  if (left_out == other.scans.size()) return no_common_time(drive, other);
  if (left_out > 0) {
    ctx.warn(concat("drive ", drive.name, ": ", left_out, " of ", other.scans.size(),
                    " scans of sensor ", other.name,
                    " are not between two scans of the first sensor and are left out"));
  }
  std::ranges::sort(scans, {}, [](const std::pair<ScanInfo, ScanOrigin>& scan) {
    return std::tuple(scan.first.stamp_ns, scan.first.sensor_index);
  });
  Drive joined = drive;
  joined.other_sensors.push_back(other.sensor);
  joined.notices.insert(joined.notices.end(), other.notices.begin(), other.notices.end());
  if (joined.turn_rates.empty()) joined.turn_rates = other.turn_rates;
  if (joined.specific_forces.empty()) joined.specific_forces = other.specific_forces;
  if (joined.wheel_speeds.empty()) joined.wheel_speeds = other.wheel_speeds;
  joined.scans.clear();
  std::vector<ScanOrigin> origins;
  std::uint32_t part = 0;
  for (auto& [scan, origin] : scans) {
    if (origin.store == 1) scan.part = part;
    part = scan.part;
    scan.recording_index =
        static_cast<std::uint32_t>(2 * joined.scans.size()) + scan.recording_index % 2;
    joined.scans.push_back(std::move(scan));
    origins.push_back(origin);
  }
  return with_store(std::move(joined),
                    joined_scan_store({drive.store, other.store}, std::move(origins)));
}

}  // namespace

Result<Drive> join_drives(PassContext& ctx, const NoOptions&, const Drive& first,
                          Many<Drive> later) {
  Drive joined = first;
  for (const Drive* drive : later) joined = with_part(ctx, joined, *drive);
  return joined;
}

Result<Drive> join_sensors(PassContext& ctx, const NoOptions&, const Drive& drive,
                           Many<Drive> others) {
  Drive joined = drive;
  for (const Drive* other : others) {
    SIGHTLINE_ASSIGN(joined, with_sensor(ctx, joined, *other));
  }
  return joined;
}

}  // namespace sightline
