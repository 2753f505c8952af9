#include "passes/trajectory/odometry.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/trajectory/following/first_steps.h"
#include "passes/trajectory/following/follower.h"

namespace sightline {
namespace {

// Errors: the first that reading a scan says.
Result<void> follow_read(PassContext& ctx, std::size_t scan_count,
                         std::span<const Result<ReadScan>> scans, FirstSteps& follower) {
  for (const Result<ReadScan>& scan : scans) {
    if (!scan) return scan.error();
    follower.take(*scan);
    ctx.progress(follower.scan_count(), scan_count);
  }
  return {};
}

// Each scan waits for those before it, but to be read: that is done ahead, side by side.
Result<void> follow_all(PassContext& ctx, const Drive& drive, FirstSteps& follower) {
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

Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given) {
  const std::size_t count = drive.scans.size();
  if (count < 2) {
    return Error{ErrorCode::kDriveTooShort,
                 "found " + std::to_string(count) + " scans, expected at least 2 to match", "",
                 "drive " + drive.name};
  }
  FirstSteps follower(Follower(drive, given, local_map_m));
  SIGHTLINE_TRY(follow_all(ctx, drive, follower));
  return std::move(follower).take_odometry();
}

}  // namespace sightline
