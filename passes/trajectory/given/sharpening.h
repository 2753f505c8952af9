#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/given/disagreements.h"

// Whether refining given poses is worth it; part of estimate-trajectory. Poses are T_map_lidar.

namespace sightline {

// About 50 m of way, and how far its given poses move otherwise than the scans over 10 m: root mean
// squares.
struct WayStretch {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  double along_m = 0.0;  // the way
  double aside_m = 0.0;
  double off_rad = 0.0;
  bool turns_otherwise = false;  // by more than matching is off
  bool moves_along = false;
  bool moves_aside = false;
};

// The whole way. Every scan has a given pose.
std::vector<WayStretch> stretches_of(const std::vector<std::optional<Pose>>& given,
                                     const Odometry& odometry,
                                     const std::vector<PoseDisagreement>& disagreements);
bool is_doubtful(const WayStretch& stretch);

// Mean map entropy, nat, and mean plane variance of scans laid on each other, as measure-sharpness
// has them, stretch by stretch.
struct Laid {
  double entropy_nat = 0.0;
  double plane_variance_m2 = 0.0;
};
struct Sharpening {
  Laid given;  // the whole way
  Laid refined;
  double doubtful_given_nat = 0.0;  // the doubtful stretches alone
  double doubtful_refined_nat = 0.0;
  bool is_sharper = false;
};

// Lays the scans by both. Refined poses are sharper where the doubtful stretches are, by 0.1 nat,
// and the whole way is no worse in either figure. Where given poses only move otherwise, refined
// ones are laid beside themselves with what the given ones drift from them in that direction alone:
// along a smooth wall refining shifts them by decimetres, and no scan can tell which are right.
// Errors: what reading a scan says.
Result<Sharpening> compare_sharpness(PassContext& ctx, const Drive& drive,
                                     const std::vector<WayStretch>& stretches,
                                     const std::vector<std::optional<Pose>>& given,
                                     const std::vector<Pose>& refined);

}  // namespace sightline
