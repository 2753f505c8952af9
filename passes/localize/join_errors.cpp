#include "passes/localize/join_errors.h"

#include <algorithm>
#include <span>

#include "formats/base/check.h"

namespace sightline {
namespace {

bool is_measured_somewhere(const ByFamily<MeasuredError>& measured) {
  return std::ranges::any_of(measured.ranges.scan_of_site,
                             [](std::int64_t scan) { return scan >= 0; });
}

// Why a drive is left out; empty: it is not.
std::string reason_to_leave_out(const Drive& first, const Drive& drive,
                                const ByFamily<MeasuredError>& errors) {
  if (drive.sensor.name != first.sensor.name) {
    return concat("its sensor is ", drive.sensor.name, ", that of the first is ",
                  first.sensor.name);
  }
  if (to_bytes(drive.sensor) != to_bytes(first.sensor)) {
    return "its sensor has another mounting or other beams than the first drive's";
  }
  return is_measured_somewhere(errors) ? "" : "it has no scan near a site of the map";
}

// Adds the drive of the next number, or leaves it out.
void add(const PassContext& ctx, const Drive& first, const Drive& drive,
         const ByFamily<MeasuredError>& errors, MeasuredDrives& joined) {
  const std::uint32_t number = joined.named_count++;
  const std::string reason = reason_to_leave_out(first, drive, errors);
  if (!reason.empty()) {
    ctx.warn(
        concat("localization drive ", number + 1, ", '", drive.name, "', is left out: ", reason));
    return;
  }
  joined.drives.push_back(errors);
  joined.numbers.push_back(number);
}

Result<void> check_joined(const MeasuredDrives& joined) {
  const Result<void> valid = validate(joined);
  if (valid) return {};
  return Error{ErrorCode::kMismatchedInputs, valid.error().message, "", valid.error().place};
}

// Takes site `site` from `from`, whose looks are those of `to`.
void take_site(const MeasuredError& from, std::size_t site, MeasuredError& to) {
  to.scan_of_site[site] = from.scan_of_site[site];
  for (std::size_t look = 0; look < from.looks.size(); ++look) {
    to.rows[to.shape().index(site, look)] = from.row(site, look);
    if (to.tracking_offsets.empty()) continue;
    const std::span<const AxisErrors> tracking = from.tracking(site, look);
    const std::size_t first = to.shape().index(site, look) * tracking.size();
    std::ranges::copy(tracking, to.tracking_ends.begin() + static_cast<std::ptrdiff_t>(first));
  }
}

// Tracking starts are kept where every drive was measured from them.
void keep_shared_tracking(const MeasuredDrives& measured, ByFamily<MeasuredError>& pooled) {
  const auto has_none = [](const ByFamily<MeasuredError>& drive) {
    return drive.ranges.tracking_offsets.empty();
  };
  if (std::ranges::none_of(measured.drives, has_none)) return;
  visit_families(pooled, [](MeasuredError& of_family) {
    of_family.tracking_offsets.clear();
    of_family.tracking_ends.clear();
  });
}

// The first drive from `turn` on, in a circle, that was measured at the site; none: their count.
std::size_t speaker_at(const MeasuredDrives& measured, std::size_t turn, std::size_t site) {
  const std::size_t count = measured.drives.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t drive = (turn + i) % count;
    if (measured.drives[drive].ranges.scan_of_site[site] >= 0) return drive;
  }
  return count;
}

}  // namespace

Result<MeasuredDrives> join_errors(PassContext& ctx, const NoOptions&, Many<Drive> drives,
                                   Many<ByFamily<MeasuredError>> errors) {
  SIGHTLINE_CHECK(drives.size() == errors.size());
  MeasuredDrives joined;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    add(ctx, *drives.front(), *drives[i], *errors[i], joined);
  }
  SIGHTLINE_TRY(check_joined(joined));
  return joined;
}

Result<ByFamily<MeasuredError>> pool_errors(PassContext&, const NoOptions&,
                                            const MeasuredDrives& measured) {
  if (measured.drives.empty()) {
    return Error{ErrorCode::kNoOverlap,
                 concat("none of ", measured.named_count,
                        " localization drives has a scan near a site of the map. Check that they "
                        "follow the mapped route"),
                 "", "pass pool-errors"};
  }
  ByFamily<MeasuredError> pooled = measured.drives.front();
  for (std::size_t i = 1; i < measured.drives.size(); ++i) {
    pooled.ranges.drive += ", " + measured.drives[i].ranges.drive;
  }
  keep_shared_tracking(measured, pooled);
  std::size_t turn = 0;
  for (std::size_t site = 0; site < pooled.ranges.scan_of_site.size(); ++site) {
    const std::size_t speaker = speaker_at(measured, turn, site);
    if (speaker == measured.drives.size()) continue;
    const ByFamily<MeasuredError>& drive = measured.drives[speaker];
    take_site(drive.ranges, site, pooled.ranges);
    if (pooled.samples) take_site(*drive.samples, site, *pooled.samples);
    ++turn;
  }
  if (pooled.samples) pooled.samples->drive = pooled.ranges.drive;
  return pooled;
}

}  // namespace sightline
