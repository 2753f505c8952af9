#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/given/disagreements.h"

namespace sightline {

// About 50 m of way, and how far its given poses move otherwise than matched scans over 10 m where
// scans constrain every step: root mean squares.
struct WayStretch {
  std::uint32_t first = 0;  // scans, by their place in the drive
  std::uint32_t last = 0;
  double along_m = 0.0;  // the way
  double aside_m = 0.0;
  double off_rad = 0.0;
  double sigma_m = 0.0;          // of the matched motions, in their least constrained direction
  bool turns_otherwise = false;  // by more than matching errors
  bool moves_along = false;
  bool moves_aside = false;
};

// The stretches of the whole way. Every scan has a given pose.
std::vector<WayStretch> stretches_of(const GivenPoses& given, const Odometry& odometry,
                                     const std::vector<PoseDisagreement>& disagreements);
bool is_doubtful(const WayStretch& stretch);

// Mean map entropy, nat, and mean plane variance of scans by some poses, as in measure-sharpness,
// stretch by stretch.
struct MeanSharpness {
  double entropy_nat = 0.0;
  double plane_variance_m2 = 0.0;
};
struct Sharpening {
  MeanSharpness given;  // the whole way
  MeanSharpness refined;
  double doubtful_given_nat = 0.0;  // the doubtful stretches alone
  double doubtful_refined_nat = 0.0;
  bool is_sharper = false;
};

// Compares both poses of the scans. Refined poses are sharper where the doubtful stretches are, by
// 0.1 nat, and the whole way is worse in neither figure. Where given poses move otherwise but turn
// alike, refined ones are compared with themselves moved by the drift of the given ones in that
// direction: along a smooth wall refining shifts poses by decimetres, which no scan can measure.
// Errors: those of reading a scan.
Result<Sharpening> compare_sharpness(PassContext& ctx, const Drive& drive,
                                     const std::vector<WayStretch>& stretches,
                                     const GivenPoses& given, const std::vector<Pose>& refined);

}  // namespace sightline
