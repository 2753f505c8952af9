#include "passes/ingest/check_pose_clock.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/units.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/grid/cell_index.h"
#include "formats/text/numbers.h"
#include "passes/ingest/pose_reading.h"

namespace sightline {
namespace {

constexpr double kVoxel_m = 0.5;
constexpr std::int64_t kFarthest_ns = 40 * kSecond_ns;
constexpr std::int64_t kStep_ns = kSecond_ns / 5;

// Two scans about a second apart.
struct TimedPair {
  std::int64_t first_ns = 0;
  std::int64_t second_ns = 0;
  CellIndex first;  // voxels with returns
  std::vector<Eigen::Vector3d> second;
};

struct ClockFit {
  std::int64_t shift_ns = 0;
  double share = 0.0;  // of returns that fall on the other scan, mean over pairs
};

Result<std::optional<TimedPair>> read_pair(const Recording& recording, std::size_t first,
                                           std::size_t second) {
  constexpr std::size_t kMostPoints = 1500;
  const Result<PointCloudFile> a = read_listed_scan(recording, first);
  const Result<PointCloudFile> b = read_listed_scan(recording, second);
  if (!a && !is_without_returns(a.error())) return a.error();
  if (!b && !is_without_returns(b.error())) return b.error();
  if (!a || !b) return std::optional<TimedPair>();
  TimedPair pair;
  pair.first_ns = recording.scans[first].stamp_ns;
  pair.second_ns = recording.scans[second].stamp_ns;
  const double height_m = recording.sensor.height_m;
  for (const Eigen::Vector3d& point_m : upright_returns(*a, height_m)) {
    pair.first.add(cell_key(point_m, kVoxel_m));
  }
  const std::vector<Eigen::Vector3d> all = upright_returns(*b, height_m);
  const std::size_t step = all.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < all.size(); i += step) pair.second.push_back(all[i]);
  if (pair.second.empty()) return std::optional<TimedPair>();
  return std::optional<TimedPair>(std::move(pair));
}

Result<std::vector<TimedPair>> read_pairs(const Recording& recording) {
  constexpr std::size_t kPairs = 12;
  constexpr std::int64_t kApart_ns = kSecond_ns;
  std::vector<TimedPair> pairs;
  const std::size_t count = recording.scans.size();
  for (std::size_t k = 0; k < kPairs; ++k) {
    const std::size_t first = k * count / kPairs;
    std::size_t second = first;
    while (second < count &&
           recording.scans[second].stamp_ns - recording.scans[first].stamp_ns < kApart_ns) {
      ++second;
    }
    if (second >= count) break;
    SIGHTLINE_ASSIGN(std::optional<TimedPair> pair, read_pair(recording, first, second));
    if (pair) pairs.push_back(*std::move(pair));
  }
  return pairs;
}

// Nothing where half of the pairs or more have no poses then.
std::optional<double> share_at(const std::vector<TimedPair>& pairs, const Recording& recording,
                               std::int64_t shift_ns) {
  const Pose& T_vehicle_lidar = recording.sensor.T_vehicle_lidar;
  double sum = 0.0;
  std::size_t known = 0;
  for (const TimedPair& pair : pairs) {
    const auto first = pose_at(recording.pose_rows, pair.first_ns + shift_ns);
    const auto second = pose_at(recording.pose_rows, pair.second_ns + shift_ns);
    if (!first || !second) continue;
    ++known;
    const Pose T_first_second = T_vehicle_lidar.inverse() * first->T_world_vehicle.inverse() *
                                second->T_world_vehicle * T_vehicle_lidar;
    std::size_t on = 0;
    for (const Eigen::Vector3d& point_m : pair.second) {
      const CellKey key = cell_key(T_first_second * point_m, kVoxel_m);
      on += pair.first.find(key) != CellIndex::kNone ? 1 : 0;
    }
    sum += static_cast<double>(on) / static_cast<double>(pair.second.size());
  }
  if (2 * known <= pairs.size()) return std::nullopt;
  return sum / static_cast<double>(known);
}

ClockFit best_fit(const std::vector<TimedPair>& pairs, const Recording& recording) {
  ClockFit best;
  for (std::int64_t shift_ns = -kFarthest_ns; shift_ns <= kFarthest_ns; shift_ns += kStep_ns) {
    const std::optional<double> share = share_at(pairs, recording, shift_ns);
    if (share && *share > best.share) best = {shift_ns, *share};
  }
  return best;
}

}  // namespace

Result<void> check_pose_clock(const Recording& recording) {
  constexpr std::size_t kFewestPairs = 6;
  constexpr double kFarBetter = 1.3;
  constexpr double kLeastShare = 0.4;
  constexpr std::int64_t kLeast_ns = kSecond_ns / 2;
  if (recording.pose_rows.size() < 2) return {};
  SIGHTLINE_ASSIGN(const std::vector<TimedPair> pairs, read_pairs(recording));
  if (pairs.size() < kFewestPairs) return {};
  const std::optional<double> as_given = share_at(pairs, recording, 0);
  if (!as_given) return {};
  const ClockFit best = best_fit(pairs, recording);
  const bool is_far_better = best.share >= kLeastShare && best.share > kFarBetter * *as_given;
  if (!is_far_better || std::abs(best.shift_ns) < kLeast_ns) return {};
  const double ahead_s = static_cast<double>(best.shift_ns) / static_cast<double>(kSecond_ns);
  return Error{ErrorCode::kMismatchedInputs,
               concat("the clock of the poses is ", fixed(std::abs(ahead_s), 1), " s ",
                      ahead_s > 0.0 ? "ahead of" : "behind",
                      " that of the scans: with poses at that time ", whole_percent(best.share),
                      " of the returns from upright surfaces fall on those of scans 1 s "
                      "apart, with the poses as given ",
                      whole_percent(*as_given),
                      ". Correct the times of the poses (GPS time is 18 s ahead of UTC)"),
               recording.source.string()};
}

}  // namespace sightline
