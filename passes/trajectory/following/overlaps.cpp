#include "passes/trajectory/following/overlaps.h"

#include <algorithm>
#include <cstddef>

#include "formats/base/parallel.h"
#include "passes/trajectory/following/follower.h"

namespace sightline {
namespace {

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

}  // namespace

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

}  // namespace sightline
