#include "passes/replay/replay_drive.h"

#include <algorithm>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/text/numbers.h"
#include "passes/replay/replayed_vehicle.h"

namespace sightline {
namespace {

// Scans that are read before they are matched in turn: a second of driving.
constexpr std::size_t kScansInBlock = 16;
// A vehicle that is not found in so many scans is elsewhere: around a start, and in the whole map.
constexpr std::size_t kScansToStart = 20;
constexpr std::size_t kScansToStartFromNothing = 100;

// Whether no pose is known from outside.
bool begins_from_nothing(const ReplayOptions& options, const ReplayInputs& inputs) {
  if (options.T_world_start) return false;
  return options.starts_from_nothing ||
         std::ranges::none_of(
             inputs.scans, [](const ListedScan& scan) { return scan.T_world_vehicle.has_value(); });
}

Error nowhere(const ReplayInputs& inputs, std::size_t tried_count) {
  return {ErrorCode::kNoOverlap,
          concat("none of the first ", tried_count,
                 " scans fits one place of the map clearly better than all others: the drive is of "
                 "another place, or places of the map look alike. Give --start X Y Z YAW"),
          "", inputs.scans.front().name};
}

Error elsewhere(const ReplayInputs& inputs, std::size_t tried_count, const Pose& start) {
  const Eigen::Vector3d at_m = start.translation();
  return {
      ErrorCode::kNoOverlap,
      concat("none of the first ", tried_count, " scans shows the map within 3 m of the start (",
             fixed(at_m.x(), 1), ", ", fixed(at_m.y(), 1), ", ", fixed(at_m.z(), 1),
             "): the drive is of another place or world, or the start is wrong. Check --start "
             "and the poses of the recording"),
      "", inputs.scans.front().name};
}

// The scans of a block, or why each cannot be read.
std::vector<std::optional<Result<Scan>>> read_block(const ReplayInputs& inputs, std::size_t first,
                                                    std::size_t end, int threads) {
  std::vector<std::optional<Result<Scan>>> scans(end - first);
  parallel_for(scans.size(), threads,
               [&](std::size_t i) { scans[i].emplace(inputs.store.read(first + i)); });
  return scans;
}

// Scans that cannot be read: few are left out.
struct Unread {
  std::size_t count = 0;
  std::optional<Error> first;
  void add(const Error& error) {
    ++count;
    if (!first) first = error;
  }
};

Result<void> check_unread(const PassContext& ctx, const Unread& unread, std::size_t scan_count) {
  if (unread.count == 0) return {};
  if (!are_few(unread.count, scan_count)) return *unread.first;
  ctx.warn(concat(unread.count, " of ", scan_count,
                  " scans cannot be read and are left out: ", to_string(*unread.first)));
  return {};
}

// Of maps that could not be read so far.
void warn_of_faults(const PassContext& ctx, const JoinedMaps& maps, std::vector<bool>& reported) {
  reported.resize(maps.count());
  for (std::size_t i = 0; i < maps.count(); ++i) {
    if (reported[i] || !maps.fault(i)) continue;
    reported[i] = true;
    ctx.warn(concat("a map cannot be read, the others are used: ", to_string(*maps.fault(i))));
  }
}

}  // namespace

Result<ReplayedDrive> replay_drive(const PassContext& ctx, const ReplayOptions& options,
                                   const ReplayInputs& inputs) {
  const std::size_t count = inputs.scans.size();
  ReplayedVehicle vehicle(options, inputs, ctx.threads);
  ReplayedDrive drive;
  Unread unread;
  std::vector<bool> reported;
  std::size_t tried_count = 0;
  Pose T_world_tried = Pose::Identity();
  const bool is_from_nothing = begins_from_nothing(options, inputs);
  const std::size_t most_tried = is_from_nothing ? kScansToStartFromNothing : kScansToStart;
  const auto not_found = [&] {
    return is_from_nothing ? nowhere(inputs, tried_count)
                           : elsewhere(inputs, tried_count, T_world_tried);
  };
  for (std::size_t first = 0; first < count; first += kScansInBlock) {
    const std::size_t end = std::min(first + kScansInBlock, count);
    std::vector<std::optional<Result<Scan>>> scans = read_block(inputs, first, end, ctx.threads);
    for (std::size_t i = first; i < end; ++i) {
      Result<Scan>& scan = *scans[i - first];
      if (!scan) {
        unread.add(scan.error());
        drive.scans.emplace_back();
        continue;
      }
      SIGHTLINE_ASSIGN(ReplayedScan result, vehicle.take(i, *std::move(scan)));
      warn_of_faults(ctx, inputs.maps, reported);
      T_world_tried = result.T_world_vehicle;
      drive.scans.push_back(std::move(result));
      if (!vehicle.has_started() && ++tried_count == most_tried) return not_found();
    }
    ctx.progress(end, count);
  }
  SIGHTLINE_TRY(check_unread(ctx, unread, count));
  if (!vehicle.has_started()) return not_found();
  drive.lost_count = vehicle.lost_count();
  return drive;
}

}  // namespace sightline
