#include "passes/replay/replay_drive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/stopwatch.h"
#include "formats/foreign/recording/left_out_scans.h"
#include "formats/text/numbers.h"
#include "passes/matching/match_starts.h"
#include "passes/replay/place_check.h"
#include "passes/replay/straighten.h"
#include "passes/trajectory/local/local_match.h"

// Why a check of its own, beside the plan's doubt: the doubt compares a match with the forecast it
// began at, and a vehicle that is lost has forecasts that agree with its wrong matches. Streets
// differ in upright surfaces, and a look of some dozen points has few of these; so the whole scan
// is compared, which takes as long as some matches, at every tenth scan.

namespace sightline {
namespace {

// Scans that are read before they are matched in turn: a second of driving.
constexpr std::size_t kScansInBlock = 16;
// A pause after which the last speed no longer predicts the pose.
constexpr std::int64_t kLongestStep_ns = 2'000'000'000;
constexpr std::size_t kCheckEvery = 10;
// So many scans in a row that contradict the map: a lorry beside the vehicle hides walls for less.
constexpr int kMostContradictions = 3;
constexpr double kReach_m = 3.0;
// Share of upright returns that meet the map: 0.35 in a sparse map of a real street and 0.95 in a
// generated one; below 0.02 in another real street, to 0.35 in another generated town. So what is
// usual of a drive decides, once it is known.
constexpr double kLeastMetAtStart = 0.36;
constexpr double kLeastOfUsual = 0.55;
constexpr double kNewestWeight = 0.2;  // of the usual share: the mean of some five checks
constexpr std::size_t kScansToStart = 20;

using PoseRows = std::array<double, 12>;

PoseRows rows_of(const Pose& pose) {
  PoseRows rows{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      rows[static_cast<std::size_t>(4 * row + column)] = pose.affine()(row, column);
    }
  }
  return rows;
}

Pose pose_of(const double rows[12]) {
  Pose pose = Pose::Identity();
  pose.affine() = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows);
  return pose;
}

bool has_matched(const sightline_match& match) {
  return match.stop != SIGHTLINE_NO_POINTS && match.stop != SIGHTLINE_NO_OVERLAP;
}

double mean_score(const sightline_match& match) {
  return match.score / std::max(1.0, static_cast<double>(match.point_count));
}

// A match, and the look that it is by.
struct Matched {
  sightline_match match{};
  MapLook look;
};

// The vehicle between two scans.
class Replay {
 public:
  Replay(const ReplayOptions& options, const ReplayInputs& inputs)
      : options_(options), inputs_(inputs), check_(inputs.localizer.info()) {}

  // The next scan. Errors: those of MapReader::look_plan.
  Result<ReplayedScan> take(std::size_t number, Scan scan);

  [[nodiscard]] bool has_started() const { return has_started_; }
  [[nodiscard]] std::uint32_t lost_count() const { return lost_count_; }

 private:
  [[nodiscard]] bool tracks() const { return result_count_ > 0; }
  [[nodiscard]] Pose predicted(std::int64_t step_ns) const;
  [[nodiscard]] std::optional<Pose> start_of(std::size_t number) const;
  Result<Matched> match(const Scan& scan, const Pose& T_world_start, bool is_tracking) const;
  [[nodiscard]] std::vector<Pose> second_starts(std::size_t number) const;
  Result<Matched> match_next(std::size_t number, const Scan& scan) const;
  Result<ReplayedScan> follow(std::size_t number, const Scan& scan);
  Result<ReplayedScan> begin(std::size_t number, const Scan& scan);
  void found(const Pose& T_world_vehicle, bool follows);
  [[nodiscard]] double least_met() const {
    return usual_met_ > 0.0 ? kLeastOfUsual * usual_met_ : kLeastMetAtStart;
  }
  void shown(double met_share);
  void lose();

  const ReplayOptions& options_;
  const ReplayInputs& inputs_;
  PlaceCheck check_;
  bool has_started_ = false;
  std::uint32_t lost_count_ = 0;
  int result_count_ = 0;  // in a row since the track began; 0: not on track
  int contradiction_count_ = 0;
  std::size_t until_check_ = 0;
  double usual_met_ = 0.0;            // of the scans that showed the map; 0: none yet
  std::optional<Pose> T_world_last_;  // as found
  Pose T_before_last_ = Pose::Identity();
  std::int64_t last_ns_ = 0;       // of T_world_last_
  std::int64_t last_step_ns_ = 0;  // how long T_before_last_ took; 0: not known
};

Pose Replay::predicted(std::int64_t step_ns) const {
  const double factor =
      last_step_ns_ > 0 ? static_cast<double>(step_ns) / static_cast<double>(last_step_ns_) : 0.0;
  return predicted_pose(*T_world_last_, T_before_last_, factor);
}

// From outside where there is anything, else where the vehicle was last.
std::optional<Pose> Replay::start_of(std::size_t number) const {
  if (!has_started_ && options_.T_world_start) return options_.T_world_start;
  if (inputs_.scans[number].T_world_vehicle) return inputs_.scans[number].T_world_vehicle;
  if (!T_world_last_) return std::nullopt;
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  return step_ns <= kLongestStep_ns ? predicted(step_ns) : *T_world_last_;
}

Result<Matched> Replay::match(const Scan& scan, const Pose& T_world_start, bool is_tracking) const {
  const sightline_points points = {scan.points_m.data(), scan.points_m.size(),
                                   sizeof(Eigen::Vector3d), 1};
  const Eigen::Vector3d sensor_m = T_world_start * inputs_.sensor.T_vehicle_lidar.translation();
  LookPlanAnswer plan;
  if (options_.every_return_m) {
    plan.first.look.range_m = *options_.every_return_m;
  } else {
    SIGHTLINE_ASSIGN(plan, inputs_.map.look_plan({sensor_m.x(), sensor_m.y(), sensor_m.z()},
                                                 options_.limit_m, is_tracking));
  }
  if (!is_tracking) plan.first.look.settles = false;
  SIGHTLINE_ASSIGN(const sightline_match match,
                   inputs_.localizer.match(points, rows_of(T_world_start), plan));
  return Matched{match, match.look_count > 1 ? plan.second : plan.first.look};
}

ReplayedScan replayed(const Matched& matched) {
  ReplayedScan scan;
  scan.state = ScanState::kLocalized;
  scan.T_world_vehicle = pose_of(matched.match.T_world_vehicle);
  scan.covariance = Eigen::Map<const Matrix6d>(matched.match.covariance);
  scan.look = matched.look;
  scan.look_count = matched.match.look_count;
  scan.point_count = matched.match.point_count;
  scan.weak = matched.match.weak;
  return scan;
}

void Replay::found(const Pose& T_world_vehicle, bool follows) {
  has_started_ = true;
  if (follows) T_before_last_ = T_world_last_->inverse(Eigen::Isometry) * T_world_vehicle;
  if (!follows) T_before_last_ = Pose::Identity();
  T_world_last_ = T_world_vehicle;
  ++result_count_;
}

void Replay::shown(double met_share) {
  usual_met_ = usual_met_ > 0.0 ? usual_met_ + kNewestWeight * (met_share - usual_met_) : met_share;
}

void Replay::lose() {
  result_count_ = 0;
  contradiction_count_ = 0;
  ++lost_count_;
}

// One pose does not predict the next: the recording's poses say how far the vehicle moved, else it
// is up to 30 m/s ahead, or slowly behind.
std::vector<Pose> Replay::second_starts(std::size_t number) const {
  const std::optional<Pose>& before = inputs_.scans[number - 1].T_world_vehicle;
  const std::optional<Pose>& now = inputs_.scans[number].T_world_vehicle;
  const bool was_before = last_ns_ == inputs_.scans[number - 1].stamp_ns;
  if (before && now && was_before) {
    return {*T_world_last_ * (before->inverse(Eigen::Isometry) * *now)};
  }
  std::vector<Pose> starts;
  for (const double ahead_m : {0.0, 1.0, 2.0, 3.0, -1.0}) {
    starts.push_back(*T_world_last_ * Eigen::Translation3d(ahead_m, 0.0, 0.0));
  }
  return starts;
}

// By the last two poses or, behind the first one, the best of several starts.
Result<Matched> Replay::match_next(std::size_t number, const Scan& scan) const {
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  if (result_count_ > 1) return match(scan, predicted(step_ns), true);
  std::optional<Matched> best;
  for (const Pose& start : second_starts(number)) {
    SIGHTLINE_ASSIGN(const Matched matched, match(scan, start, false));
    if (!best || mean_score(matched.match) > mean_score(best->match)) best = matched;
  }
  return *best;
}

Result<ReplayedScan> Replay::follow(std::size_t number, const Scan& scan) {
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  SIGHTLINE_ASSIGN(const Matched matched, match_next(number, scan));
  ReplayedScan result = replayed(matched);
  const bool is_doubted = matched.match.look_count > 1 || !has_matched(matched.match);
  if (is_doubted || contradiction_count_ > 0 || until_check_ == 0) {
    const std::optional<double> share =
        check_.met_share(upright_of(scan, inputs_.sensor), result.T_world_vehicle);
    const bool contradicts = !has_matched(matched.match) || (share && *share < least_met());
    if (share && !contradicts) shown(*share);
    contradiction_count_ = contradicts ? contradiction_count_ + 1 : 0;
    until_check_ = kCheckEvery;
  }
  --until_check_;
  result.is_in_doubt = is_doubted || contradiction_count_ > 0;
  if (contradiction_count_ >= kMostContradictions) {
    result.state = ScanState::kLost;
    lose();
    return result;
  }
  found(result.T_world_vehicle, true);
  last_step_ns_ = step_ns;
  last_ns_ = inputs_.scans[number].stamp_ns;
  return result;
}

// The start itself, then those around it.
std::vector<Pose> starts_from(const Pose& T_world_start) {
  std::vector<Pose> starts = {T_world_start};
  for (const Pose& start : starts_around(T_world_start, kReach_m)) starts.push_back(start);
  return starts;
}

Result<ReplayedScan> Replay::begin(std::size_t number, const Scan& scan) {
  const std::optional<Pose> T_world_start = start_of(number);
  if (!T_world_start) {
    return Error{ErrorCode::kNoPoses,
                 "no start is known. Give --start X Y Z YAW, or poses of the recording", "",
                 inputs_.scans[number].name};
  }
  const std::vector<Eigen::Vector3d> upright_m = upright_of(scan, inputs_.sensor);
  ReplayedScan best;
  double best_share = -1.0;
  for (const Pose& start : starts_from(*T_world_start)) {
    SIGHTLINE_ASSIGN(const Matched matched, match(scan, start, false));
    const ReplayedScan result = replayed(matched);
    const double share = check_.met_share(upright_m, result.T_world_vehicle).value_or(0.0);
    if (!has_matched(matched.match) || share <= best_share) continue;
    best = result;
    best_share = share;
    if (share >= least_met()) break;
  }
  best.begins = true;
  if (best_share < least_met()) {
    best.state = ScanState::kLost;
    best.T_world_vehicle = *T_world_start;
    return best;
  }
  shown(best_share);
  found(best.T_world_vehicle, false);
  last_step_ns_ = 0;
  last_ns_ = inputs_.scans[number].stamp_ns;
  until_check_ = kCheckEvery;
  return best;
}

Result<ReplayedScan> Replay::take(std::size_t number, Scan scan) {
  const double begin_ms = thread_cpu_ms();
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  if (tracks() && step_ns > kLongestStep_ns) result_count_ = 0;
  const VehicleMotion motion = {T_before_last_, tracks() ? last_step_ns_ : 0};
  straighten(scan, motion, inputs_.sensor.T_vehicle_lidar);
  Result<ReplayedScan> result = tracks() ? follow(number, scan) : begin(number, scan);
  if (result) result->time_ms = thread_cpu_ms() - begin_ms;
  return result;
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

}  // namespace

Result<ReplayedDrive> replay_drive(const PassContext& ctx, const ReplayOptions& options,
                                   const ReplayInputs& inputs) {
  const std::size_t count = inputs.scans.size();
  Replay replay(options, inputs);
  ReplayedDrive drive;
  Unread unread;
  std::size_t tried_count = 0;
  Pose T_world_tried = Pose::Identity();
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
      SIGHTLINE_ASSIGN(ReplayedScan result, replay.take(i, *std::move(scan)));
      T_world_tried = result.T_world_vehicle;
      drive.scans.push_back(std::move(result));
      if (!replay.has_started() && ++tried_count == kScansToStart) {
        return elsewhere(inputs, tried_count, T_world_tried);
      }
    }
    ctx.progress(end, count);
  }
  SIGHTLINE_TRY(check_unread(ctx, unread, count));
  if (!replay.has_started()) return elsewhere(inputs, tried_count, T_world_tried);
  drive.lost_count = replay.lost_count();
  return drive;
}

}  // namespace sightline
