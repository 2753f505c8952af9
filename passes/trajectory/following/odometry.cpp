#include "passes/trajectory/following/odometry.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/trajectory/following/follower.h"

namespace sightline {
namespace {

// After so many scans a wrong speed is metres off.
constexpr std::size_t kTrialScans = 10;
// A follower with so much less overlap than the best is dropped earlier.
constexpr double kFarBehind = 0.1;
// The drive followed again at the best speed is preferred where it loses no more overlap.
constexpr double kAsGood = 0.005;
// Followers nearer to each other are on one way.
constexpr double kOneWay_m = 0.3;

// Mean over the scans from `begin` on; 0 for a scan that was found nowhere, or with a leap.
double mean_overlap(const Odometry& odometry, std::size_t begin) {
  double sum = 0.0;
  for (std::size_t k = begin; k < odometry.overlap.size(); ++k) {
    const bool leaps = !odometry.constraint[k].leap_m.isZero(0.0);
    sum += leaps ? 0.0 : odometry.overlap[k].value_or(0.0);
  }
  return sum / static_cast<double>(odometry.overlap.size() - begin);
}

bool are_one(const Follower& a, const Follower& b) {
  const Pose& T_map_a = a.odometry.T_map_lidar.back();
  const Pose& T_map_b = b.odometry.T_map_lidar.back();
  return (T_map_a.translation() - T_map_b.translation()).norm() < kOneWay_m;
}

// Follows a drive from every step that a piece may begin with, until ten scans distinguish them. Of
// the first two scans alone the best match may be wrong: rings on the road and along walls coincide
// whether the vehicle moved or not, so a vehicle that begins at speed would seem to stand still.
// After a wrong motion, ever less of what is upright meets earlier scans.
class FirstSteps {
 public:
  explicit FirstSteps(Follower follower) : followed_{std::move(follower)} {}

  // The next scan of the drive.
  void take(const ReadScan& scan) {
    if (followed_.size() == 1 && followed_.front().is_at_first_step()) return begin_trials(scan);
    const bool is_trial = followed_.size() > 1;
    if (is_trial) scans_.push_back(scan);
    for (Follower& follower : followed_) follower.take(scan);
    if (!is_trial) return;
    forget_beaten();
    if (followed_.size() == 1 || scan_count() == trial_begin_ + kTrialScans) end_trials();
  }

  // Chooses the best so far where the drive ends before ten scans.
  [[nodiscard]] Odometry take_odometry() && {
    if (followed_.size() > 1) end_trials();
    return std::move(followed_.front().odometry);
  }

 private:
  [[nodiscard]] std::size_t scan_count() const {
    return followed_.front().odometry.T_map_lidar.size();
  }

  void begin_trials(const ReadScan& scan) {
    trial_begin_ = scan_count();
    scans_ = {scan};
    before_ = followed_;
    const Follower& before = before_.front();
    followed_.front().take(scan);
    const bool is_found = followed_.front().odometry.is_matched.back();
    const std::vector<LocalMatch> steps =
        is_found ? before.first_steps(scan) : std::vector<LocalMatch>();
    for (const LocalMatch& step : steps) {
      Follower other = before;
      other.take_there(scan, step);
      if (!are_one(other, followed_.front())) followed_.push_back(std::move(other));
    }
    if (followed_.size() == 1) forget_trial();
  }

  // Drops followers that are where a better one is, or far behind the best.
  void forget_beaten() {
    std::vector<double> worths;
    for (const Follower& follower : followed_) {
      worths.push_back(mean_overlap(follower.odometry, trial_begin_));
    }
    const double most = std::ranges::max(worths);
    std::vector<Follower> left;
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      bool is_beaten = worths[i] < most - kFarBehind;
      for (std::size_t j = 0; j < followed_.size(); ++j) {
        const bool is_better = worths[j] > worths[i] || (worths[j] == worths[i] && j < i);
        is_beaten = is_beaten || (is_better && are_one(followed_[i], followed_[j]));
      }
      if (!is_beaten) left.push_back(followed_[i]);
    }
    followed_ = std::move(left);
  }

  // A follower that reached the right speed may have begun with a step or two that were wrong: the
  // drive is followed again from that speed, and preferred where the overlap is as large.
  void end_trials() {
    const auto worth = [&](const Follower& one) {
      return mean_overlap(one.odometry, trial_begin_);
    };
    Follower best = *std::ranges::max_element(followed_, {}, worth);
    Follower again = before_.front();
    again.begin_with(scans_.front(), best.last_step());
    for (std::size_t i = 1; i < scans_.size(); ++i) again.take(scans_[i]);
    const bool is_as_good = worth(again) >= worth(best) - kAsGood;
    followed_ = {is_as_good ? std::move(again) : std::move(best)};
    forget_trial();
  }

  void forget_trial() {
    before_.clear();
    scans_.clear();
  }

  // One where the first step is known; else several, first the one whose first step matches best.
  std::vector<Follower> followed_;
  // During a trial: the follower before it, and its scans.
  std::vector<Follower> before_;
  std::vector<ReadScan> scans_;
  std::size_t trial_begin_ = 0;  // scan
};

// Reports how many scans of all runs are followed.
class Progress {
 public:
  Progress(const PassContext& ctx, std::span<const ScanRun> runs) : ctx_(ctx) {
    for (const ScanRun& run : runs) total_ += run.end - run.first;
  }
  void add_one() { ctx_.progress(++done_, total_); }

 private:
  const PassContext& ctx_;
  std::size_t total_ = 0;
  std::atomic<std::size_t> done_ = 0;
};

// Scans are followed in order, and read ahead in parallel.
Result<void> follow_run(const Drive& drive, const ScanRun& run, Upright upright, int threads,
                        FirstSteps& follower, Progress& progress) {
  constexpr std::size_t kAhead = 8;  // scans
  std::vector<Result<ReadScan>> read;
  const auto follow_read = [&]() -> Result<void> {
    for (const Result<ReadScan>& scan : read) {
      if (!scan) return scan.error();
      follower.take(*scan);
      progress.add_one();
    }
    return {};
  };
  for (std::size_t end = run.first;;) {
    std::vector<Result<ReadScan>> next(std::min(kAhead, run.end - end), ReadScan{});
    Result<void> followed;
    parallel_for(1 + next.size(), threads, [&](std::size_t i) {
      if (i == 0) {
        followed = follow_read();
      } else {
        next[i - 1] = read_scan(drive, end + i - 1, upright);
      }
    });
    SIGHTLINE_TRY(followed);
    if (next.empty()) return {};
    end += next.size();
    read = std::move(next);
  }
}

// The upright points along one piece.
class PieceOverlaps {
 public:
  explicit PieceOverlaps(double local_map_m) : upright_(local_map_m) {}

  std::optional<double> take(const ReadScan& scan, const Pose& T_map_lidar, double driven_m) {
    const bool is_first = !T_map_last_;
    const std::optional<double> overlap =
        is_first ? std::nullopt : upright_.overlap(scan.upright_m, T_map_lidar);
    if (is_first || is_key_step(*T_map_last_, T_map_lidar)) {
      upright_.add(scan.upright_to_map_m, T_map_lidar, driven_m);
      T_map_last_ = T_map_lidar;
    }
    return overlap;
  }

 private:
  UprightMap upright_;
  std::optional<Pose> T_map_last_;  // the last key scan
};

constexpr double kLocalMapsOfTwoRuns = 10.0;
// A run begins with a local map of so many scans, even if a given pose jumps.
constexpr double kLeastScansOfLocalMap = 10.0;

// Scans of one part from `begin` on, with given steps between them, and the way up to each.
struct GivenWay {
  std::size_t begin = 0;
  std::vector<double> way_m = {0.0};
};

// Adds the runs that begin within such a way.
void add_runs_within(const GivenWay& given, double local_map_m, std::vector<ScanRun>& runs) {
  const std::vector<double>& way_m = given.way_m;
  const double pairs = way_m.back() / (kLocalMapsOfTwoRuns * local_map_m);
  // Even: with three runs and two threads, one thread would be idle during the last.
  const double count = pairs < 1.0 ? 1.0 : 2.0 * std::round(pairs);
  for (double i = 1.0; i < count; i += 1.0) {
    const auto begin = std::ranges::lower_bound(way_m, way_m.back() * i / count);
    const auto first = std::ranges::lower_bound(way_m.begin(), begin, *begin - local_map_m);
    runs.push_back({given.begin + static_cast<std::size_t>(first - way_m.begin()),
                    given.begin + static_cast<std::size_t>(begin - way_m.begin())});
  }
}

void append_run(const ScanRun& run, const Odometry& found, Odometry& joined) {
  const bool begins_piece = run.first == run.begin;
  const std::size_t before = begins_piece ? 0 : run.begin - run.first - 1;  // in both
  const Pose T_joined_found = joined.T_map_lidar.back() * found.T_map_lidar[before].inverse();
  const std::uint32_t first_piece = joined.piece.back() + (begins_piece ? 1 : 0);
  if (begins_piece) {
    joined.piece_starts.push_back({static_cast<std::uint32_t>(run.begin), true, 0.0, 0.0});
  }
  joined.piece_starts.insert(joined.piece_starts.end(), found.piece_starts.begin(),
                             found.piece_starts.end());
  for (std::size_t k = run.begin - run.first; k < found.T_map_lidar.size(); ++k) {
    const Pose& T_found_lidar = found.T_map_lidar[k];
    const Pose& T_found_last = found.T_map_lidar[k == 0 ? 0 : k - 1];
    joined.append(tidied(T_joined_found * T_found_lidar),
                  (T_found_lidar.translation() - T_found_last.translation()).norm(),
                  found.is_matched[k], found.overlap[k]);
    joined.is_far.back() = found.is_far[k];
    joined.constraint.back() = found.constraint[k];
    joined.piece.back() = first_piece + found.piece[k];
  }
  if (begins_piece) joined.is_matched[run.begin] = false;
}

}  // namespace

bool lead_to_all(const GivenPoses& given) {
  return std::ranges::all_of(given, [](const auto& pose) { return pose.has_value(); });
}

void start_at_given(const GivenPoses& given, Odometry& odometry) {
  const auto first = std::ranges::find_if(given, [](const auto& pose) { return bool(pose); });
  if (first == given.end() || first == given.begin()) return;
  const auto number = static_cast<std::size_t>(first - given.begin());
  const Pose T_given_found = **first * odometry.T_map_lidar[number].inverse();
  for (Pose& pose : odometry.T_map_lidar) pose = T_given_found * pose;
}

Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const GivenPoses& given) {
  const std::size_t count = drive.scans.size();
  if (count < 2) {
    return Error{ErrorCode::kDriveTooShort,
                 concat("found ", count, " scans, expected at least 2 to match"), "",
                 "drive " + drive.name};
  }
  const Upright upright = lead_to_all(given) ? Upright::kLeftOut : Upright::kComputed;
  const std::vector<ScanRun> runs = scan_runs(drive, given, local_map_m);
  const SpeedForecast speed = lead_to_all(given) ? SpeedForecast() : SpeedForecast(drive);
  Progress progress(ctx, runs);
  std::vector<Result<void>> done(runs.size());
  std::vector<Odometry> followed(runs.size());
  parallel_for(runs.size(), ctx.threads, [&](std::size_t i) {
    FirstSteps follower(Follower(drive, given, local_map_m, runs[i].first, speed));
    done[i] = follow_run(drive, runs[i], upright, ctx.threads, follower, progress);
    followed[i] = std::move(follower).take_odometry();
  });
  for (const Result<void>& one : done) SIGHTLINE_TRY(one);
  return joined_runs(runs, followed);
}

Result<std::vector<std::optional<double>>> overlaps_along(const PassContext& ctx,
                                                          const Drive& drive, double local_map_m,
                                                          const Odometry& odometry) {
  constexpr std::size_t kAtOnce = 64;  // scans
  const std::size_t count = drive.scans.size();
  std::vector<std::optional<double>> overlaps;
  PieceOverlaps piece(local_map_m);
  for (std::size_t begin = 0; begin < count; begin += kAtOnce) {
    std::vector<Result<ReadScan>> read(std::min(kAtOnce, count - begin), ReadScan{});
    parallel_for(read.size(), ctx.threads,
                 [&](std::size_t i) { read[i] = read_scan(drive, begin + i, Upright::kComputed); });
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (!read[i]) return read[i].error();
      const std::size_t k = begin + i;
      if (k > 0 && odometry.piece[k] != odometry.piece[k - 1]) piece = PieceOverlaps(local_map_m);
      overlaps.push_back(piece.take(*read[i], odometry.T_map_lidar[k], odometry.driven_m[k]));
    }
  }
  return overlaps;
}

std::vector<ScanRun> scan_runs(const Drive& drive, const GivenPoses& given, double local_map_m) {
  const double longest_step_m = local_map_m / kLeastScansOfLocalMap;
  std::vector<ScanRun> runs = {{}};
  GivenWay way;
  for (std::size_t k = 1; k < drive.scans.size(); ++k) {
    const bool begins_part = drive.scans[k].part != drive.scans[k - 1].part;
    if (!begins_part && given[k - 1] && given[k]) {
      const Eigen::Vector3d step_m = given[k]->translation() - given[k - 1]->translation();
      way.way_m.push_back(way.way_m.back() + std::min(step_m.norm(), longest_step_m));
      continue;
    }
    add_runs_within(way, local_map_m, runs);
    way = {.begin = k};
    if (begins_part) runs.push_back({k, k});
  }
  add_runs_within(way, local_map_m, runs);
  for (std::size_t i = 1; i < runs.size(); ++i) runs[i - 1].end = runs[i].begin;
  runs.back().end = drive.scans.size();
  return runs;
}

Odometry joined_runs(std::span<const ScanRun> runs, const std::vector<Odometry>& followed) {
  Odometry joined = followed.front();
  for (std::size_t i = 1; i < runs.size(); ++i) append_run(runs[i], followed[i], joined);
  return joined;
}

}  // namespace sightline
