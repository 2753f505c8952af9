#pragma once

#include <string>
#include <vector>

#include "passes/replay/replay_drive.h"

namespace sightline {

// Ten scans a tenth of a second and a metre apart at x = 1000 m: scan 2 in doubt, 5 skipped, 7 and
// 8 lost, all others localized.
struct SmallReplay {
  std::vector<ListedScan> scans;
  ReplayedDrive drive;
};

inline SmallReplay small_replay() {
  SmallReplay small;
  for (int i = 0; i < 10; ++i) {
    small.scans.push_back({1'000'000'000'000 + 100'000'000 * i, std::to_string(i) + ".pcd", {}});
    ReplayedScan& scan = small.drive.scans.emplace_back();
    scan.state = i == 5             ? ScanState::kSkipped
                 : i == 7 || i == 8 ? ScanState::kLost
                                    : ScanState::kLocalized;
    scan.is_in_doubt = i == 2;
    scan.T_world_vehicle.translation() = Eigen::Vector3d(1000.0 + i, -2.0, 0.5);
    scan.covariance = 0.0004 * Matrix6d::Identity();
    scan.look = {.range_m = 30.0, .return_count = 300, .point_count = 60};
    scan.look_count = i == 2 ? 2 : 1;
    scan.point_count = 60;
    scan.weak = i == 3 ? 33U : 0U;
    scan.time_ms = 1.0 + i;
  }
  small.drive.lost_count = 1;
  return small;
}

}  // namespace sightline
