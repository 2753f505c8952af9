#include "passes/trajectory/following/odometry.h"

#include <algorithm>
#include <atomic>
#include <span>
#include <string>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/trajectory/following/first_steps.h"
#include "passes/trajectory/following/follower.h"
#include "passes/trajectory/following/scan_runs.h"

namespace sightline {
namespace {

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

// Errors: the first of reading a scan.
Result<void> follow_read(std::span<const Result<ReadScan>> scans, FirstSteps& follower,
                         Progress& progress) {
  for (const Result<ReadScan>& scan : scans) {
    if (!scan) return scan.error();
    follower.take(*scan);
    progress.add_one();
  }
  return {};
}

// Scans are followed in order, and read ahead in parallel.
Result<void> follow_run(const Drive& drive, const ScanRun& run, Upright upright, int threads,
                        FirstSteps& follower, Progress& progress) {
  constexpr std::size_t kAhead = 8;  // scans
  std::vector<Result<ReadScan>> read;
  for (std::size_t end = run.first;;) {
    std::vector<Result<ReadScan>> next(std::min(kAhead, run.end - end), ReadScan{});
    Result<void> followed;
    parallel_for(1 + next.size(), threads, [&](std::size_t i) {
      if (i == 0) {
        followed = follow_read(read, follower, progress);
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
                 "found " + std::to_string(count) + " scans, expected at least 2 to match", "",
                 "drive " + drive.name};
  }
  const Upright upright = lead_to_all(given) ? Upright::kLeftOut : Upright::kComputed;
  const std::vector<ScanRun> runs = scan_runs(drive, given, local_map_m);
  Progress progress(ctx, runs);
  std::vector<Result<void>> done(runs.size());
  std::vector<Odometry> followed(runs.size());
  parallel_for(runs.size(), ctx.threads, [&](std::size_t i) {
    FirstSteps follower(Follower(drive, given, local_map_m, runs[i].first));
    done[i] = follow_run(drive, runs[i], upright, ctx.threads, follower, progress);
    followed[i] = std::move(follower).take_odometry();
  });
  for (const Result<void>& one : done) SIGHTLINE_TRY(one);
  return joined_runs(runs, followed);
}

}  // namespace sightline
