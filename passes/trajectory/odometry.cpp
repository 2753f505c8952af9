#include "passes/trajectory/odometry.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/rotation.h"
#include "passes/trajectory/pieces/even_motion.h"
#include "passes/trajectory/pieces/place_widely.h"
#include "passes/trajectory/pieces/scan_overlap.h"

namespace sightline {
namespace {

// Where less of a scan's upright returns meets the local map than this, or than this share of what
// is usual, it is looked for farther around: steps of a few metres still have 0.7.
constexpr double kPoorOverlap = 0.6;
constexpr double kPoorShare = 0.75;
// Less is met by chance: a place is not believed.
constexpr double kLeastOverlap = 0.35;
// A drop below this share of what is usual is not believed of a scan that was not searched for.
constexpr double kLeastShareOfUsual = 0.5;
// So much more must meet the map than in any other place; and than where even motion leads.
constexpr double kClearly = 0.08;
constexpr std::int64_t kShortestJump_ns = 1'000'000'000;

// A scan as it is matched, and as it is remembered.
struct ReadScan {
  ThinnedScan thinned;
  std::vector<Eigen::Vector3d> upright_m;         // of to_match_m
  std::vector<Eigen::Vector3d> upright_to_map_m;  // of to_map_m
};

Result<ReadScan> read_scan(const Drive& drive, std::size_t k) {
  ReadScan scan;
  SIGHTLINE_ASSIGN(scan.thinned, read_thinned(drive, k));
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  scan.upright_m = upright_points(scan.thinned.to_match_m, level);
  scan.upright_to_map_m = upright_points(scan.thinned.to_map_m, level);
  return scan;
}

// Where a scan is found, with the overlap that speaks for it.
struct Found {
  LocalMatch match;
  std::optional<double> overlap;
  double overlap_elsewhere = 0.0;
  bool is_believed = false;
  bool is_wide = false;  // not where even motion leads
  bool is_far = false;   // found by the search farther around
};

// Follows a drive from scan to scan.
class Follower {
 public:
  Follower(const Drive& drive, const std::vector<std::optional<Pose>>& given, double local_map_m)
      : drive_(drive),
        given_(given),
        local_map_m_(local_map_m),
        longest_step_ns_(longest_step_ns(drive)),
        map_(local_map_m),
        upright_(local_map_m) {}

  void take(const ReadScan& scan) {
    const std::size_t k = odometry.T_map_lidar.size();
    if (k == 0) {
      append(given_[0].value_or(drive_.sensor.T_vehicle_lidar), false, {});
    } else if (has_given_step(k)) {
      follow_with_given(k, scan);
    } else {
      follow_alone(k, scan);
    }
    remember(k, scan);
  }
  Odometry odometry;

 private:
  [[nodiscard]] bool begins_part(std::size_t k) const {
    return drive_.scans[k].part != drive_.scans[k - 1].part;
  }
  [[nodiscard]] bool has_given_step(std::size_t k) const {
    return given_[k - 1] && given_[k] && !begins_part(k);
  }
  [[nodiscard]] std::int64_t step_ns(std::size_t k) const {
    return drive_.scans[k].stamp_ns - drive_.scans[k - 1].stamp_ns;
  }
  // After which the last steps do not say how far the drive has gone on.
  [[nodiscard]] bool is_jump(std::size_t k) const {
    return step_ns(k) > longest_step_ns_ || begins_part(k);
  }
  [[nodiscard]] const Pose& T_map_before() const { return odometry.T_map_lidar.back(); }

  // Where scan k may be, by what is known of its motion; the likeliest first.
  [[nodiscard]] std::vector<Pose> predictions(std::size_t k) const {
    std::vector<Pose> starts;
    if (was_found_widely_) starts.push_back(moved_on(k));
    for (const TimedStep& step : steps_) {
      starts.push_back(T_map_before() * carried_on(step, step_ns(k)));
    }
    if (steps_.empty()) starts.push_back(T_map_before());
    if (has_given_step(k)) {
      starts.push_back(T_map_before() * given_[k - 1]->inverse() * *given_[k]);
    }
    for (Pose& start : starts) start = tidied(start);
    return starts;
  }

  // On as the last step led, without its turn: who looks aside walks on.
  [[nodiscard]] Pose moved_on(std::size_t k) const {
    Pose start = T_map_before();
    if (steps_.empty()) return start;
    const Pose T_map_last_but_one = T_map_before() * steps_.front().T_before_after.inverse();
    const Pose straight = carried_on(
        {Eigen::Translation3d(T_map_before().translation() - T_map_last_but_one.translation()) *
             Pose::Identity(),
         steps_.front().time_ns},
        step_ns(k));
    start.translation() += straight.translation();
    return start;
  }

  [[nodiscard]] Found follow_from(const std::vector<Pose>& starts, const ReadScan& scan) const {
    Found found;
    found.match = follow(map_.grids(), scan.thinned.to_match_m, starts, T_map_before(), average_);
    found.overlap = upright_.overlap(scan.upright_m, found.match.T_map_lidar);
    return found;
  }

  void follow_with_given(std::size_t k, const ReadScan& scan) {
    const std::vector<Pose> starts = predictions(k);
    Found found;
    // Behind a jump the given pose stands: what was seen before it may be far from here, and a
    // street that looks like another would speak against poses that are right.
    if (!is_jump(k)) found = follow_from(starts, scan);
    const bool is_matched = found.match.is_good();
    if (is_matched) average_.add(found.match, found.overlap);
    const Pose T_map_lidar = is_matched ? found.match.T_map_lidar : starts.back();
    steps_ = {{T_map_before().inverse() * T_map_lidar, step_ns(k)}};
    append(T_map_lidar, is_matched, found.overlap);
  }

  void follow_alone(std::size_t k, const ReadScan& scan) {
    Found found;
    if (!is_jump(k)) found = find(k, scan);
    if (!found.is_believed) {
      begin_piece({static_cast<std::uint32_t>(k), is_jump(k),
                   found.match.is_good() ? found.overlap.value_or(0.0) : 0.0,
                   found.overlap_elsewhere});
      return;
    }
    average_.add(found.match, found.overlap);
    const TimedStep step{T_map_before().inverse() * found.match.T_map_lidar, step_ns(k)};
    was_found_widely_ = found.is_wide;
    if (found.is_wide && !steps_.empty()) {
      // The drive may have jumped and go on as before, or be as fast as that.
      steps_ = {step, steps_.front()};
    } else {
      steps_ = {step};
    }
    append(found.match.T_map_lidar, true, found.overlap);
    odometry.is_far.back() = found.is_far;
  }

  [[nodiscard]] bool is_poor(const Found& found) const {
    if (!found.match.is_good()) return true;
    const double least = std::max(kPoorOverlap, kPoorShare * average_.overlap);
    return found.overlap && *found.overlap < least;
  }

  // Where even motion leads; where that is poor, turned or wherever else it is.
  [[nodiscard]] Found find(std::size_t k, const ReadScan& scan) const {
    Found found = follow_from(predictions(k), scan);
    found.is_believed = found.match.is_good();
    if (!is_poor(found)) return found;
    const double least = std::max(kLeastOverlap, kLeastShareOfUsual * average_.overlap);
    const double overlap = found.match.is_good() ? found.overlap.value_or(1.0) : 0.0;
    found.is_believed = found.is_believed && overlap >= least;
    const LocalSurroundings there{map_.grids(), upright_};
    const SoughtScan sought{scan.thinned.to_match_m, scan.upright_m};
    const std::optional<WidePlacement> turned =
        place_turned(there, sought, {moved_on(k), T_map_before()});
    if (turned && turned->overlap >= std::max(least, overlap + kClearly)) {
      const Found near{turned->match, turned->overlap, 0.0, true, true};
      if (!is_poor(near)) return near;
    }
    return find_widely(there, sought, found);
  }

  [[nodiscard]] Found find_widely(const LocalSurroundings& there, const SoughtScan& sought,
                                  const Found& followed) const {
    const std::optional<WidePlacement> wide = place_widely(there, sought, T_map_before(), {});
    const double overlap = followed.match.is_good() ? followed.overlap.value_or(1.0) : 0.0;
    if (!wide || wide->overlap < overlap + kClearly) return followed;
    const bool is_other = are_elsewhere(wide->match.T_map_lidar, followed.match.T_map_lidar);
    const double elsewhere =
        is_other ? std::max(overlap, wide->overlap_elsewhere) : wide->overlap_elsewhere;
    const bool is_believed =
        wide->overlap >= kLeastOverlap && wide->overlap >= elsewhere + kClearly;
    return {wide->match, wide->overlap, elsewhere, is_believed, true, true};
  }

  // With a map of its own, and nothing known of the speed.
  void begin_piece(const PieceStart& start) {
    odometry.piece_starts.push_back(start);
    was_found_widely_ = false;
    map_ = LocalMap(local_map_m_);
    upright_ = UprightMap(local_map_m_);
    average_ = {};
    steps_.clear();
    is_map_empty_ = true;
    append(T_map_before(), false, {});
  }

  void append(const Pose& T_map_lidar, bool is_matched, std::optional<double> overlap) {
    const bool is_first = odometry.T_map_lidar.empty();
    const double step_m =
        is_first ? 0.0 : (T_map_lidar.translation() - T_map_before().translation()).norm();
    odometry.driven_m.push_back(is_first ? 0.0 : odometry.driven_m.back() + step_m);
    odometry.T_map_lidar.push_back(T_map_lidar);
    odometry.is_matched.push_back(is_matched || is_first);
    odometry.is_far.push_back(false);
    odometry.piece.push_back(static_cast<std::uint32_t>(odometry.piece_starts.size()));
    odometry.overlap.push_back(overlap);
  }

  void remember(std::size_t k, const ReadScan& scan) {
    const Pose& T_map_lidar = odometry.T_map_lidar.back();
    if (!is_map_empty_ && !map_.wants(T_map_lidar)) return;
    is_map_empty_ = false;
    map_.add(scan.thinned.to_map_m, T_map_lidar, odometry.driven_m[k]);
    upright_.add(scan.upright_to_map_m, T_map_lidar, odometry.driven_m[k]);
  }

  const Drive& drive_;
  const std::vector<std::optional<Pose>>& given_;
  double local_map_m_;
  std::int64_t longest_step_ns_;
  LocalMap map_;
  UprightMap upright_;
  RunningAverage average_;
  std::vector<TimedStep> steps_;  // that the drive may go on with
  bool was_found_widely_ = false;
  bool is_map_empty_ = true;
};

// Errors: the first that reading a scan says.
Result<void> follow_read(PassContext& ctx, std::size_t scan_count,
                         std::span<const Result<ReadScan>> scans, Follower& follower) {
  for (const Result<ReadScan>& scan : scans) {
    if (!scan) return scan.error();
    follower.take(*scan);
    ctx.progress(follower.odometry.T_map_lidar.size(), scan_count);
  }
  return {};
}

// Each scan waits for those before it, but to be read: that is done ahead, side by side.
Result<void> follow_all(PassContext& ctx, const Drive& drive, Follower& follower) {
  constexpr std::size_t kAhead = 8;  // scans
  const std::size_t count = drive.scans.size();
  std::vector<Result<ReadScan>> read;
  for (std::size_t end = 0;;) {
    std::vector<Result<ReadScan>> next(std::min(kAhead, count - end), ReadScan{});
    Result<void> followed;
    parallel_for(1 + next.size(), ctx.threads, [&](std::size_t i) {
      if (i == 0) {
        followed = follow_read(ctx, count, read, follower);
      } else {
        next[i - 1] = read_scan(drive, end + i - 1);
      }
    });
    SIGHTLINE_TRY(followed);
    if (next.empty()) return {};
    end += next.size();
    read = std::move(next);
  }
}

}  // namespace

std::int64_t longest_step_ns(const Drive& drive) {
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < drive.scans.size(); ++i) {
    steps_ns.push_back(drive.scans[i].stamp_ns - drive.scans[i - 1].stamp_ns);
  }
  if (steps_ns.empty()) return kShortestJump_ns;
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::ranges::nth_element(steps_ns, middle);
  return std::max(kShortestJump_ns, 3 * *middle);
}

Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given) {
  const std::size_t count = drive.scans.size();
  if (count < 2) {
    return Error{ErrorCode::kDriveTooShort,
                 "found " + std::to_string(count) + " scans, expected at least 2 to match", "",
                 "drive " + drive.name};
  }
  Follower follower(drive, given, local_map_m);
  SIGHTLINE_TRY(follow_all(ctx, drive, follower));
  return std::move(follower.odometry);
}

}  // namespace sightline
