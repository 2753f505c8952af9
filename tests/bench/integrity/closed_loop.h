#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "formats/drive/look.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/covariance/match_covariance.h"
#include "passes/matching/covariance/structure_information.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "tests/bench/integrity/integrity_world.h"
#include "tests/bench/integrity/pose_filter.h"

namespace sightline {

// Where the covariance of a match comes from.
enum class CovarianceSource {
  kFixed,     // 0.0225 m^2 and 0.000625 rad^2, Autoware's default
  kLaplace,   // inverse Hessian of the score
  kMultiNdt,  // spread of matches from six offsets, as Autoware's MULTI_NDT; yaw as fixed
  kStructure  // scaled structure information
};
std::string_view source_name(CovarianceSource source);

// A world's map, made ready to be localized in.
class WorldLocalizer {
 public:
  WorldLocalizer(const IntegrityWorld& world, const Look& look);
  WorldLocalizer(const WorldLocalizer&) = delete;
  WorldLocalizer& operator=(const WorldLocalizer&) = delete;

  void take(const Scan& scan);
  MatchResult match(const Pose& T_map_start,
                    double search_m = std::numeric_limits<double>::infinity());
  // Of the last match.
  MatchEnd end(const MatchResult& found, const KnownStart& start, const InformationScale& scale);
  StructureEvidence structure(const Pose& T_map_vehicle);

  [[nodiscard]] std::size_t point_count() const { return matcher_.point_count(); }

  // CPU time of all cuts and matches, and of all information.
  [[nodiscard]] double match_s() const { return match_s_; }
  [[nodiscard]] double information_s() const { return information_s_; }

 private:
  Look look_;
  Localizer own_;
  Localizer samples_;
  StructureMap structures_;
  SensorProfile sensor_;
  LookMatcher matcher_;
  StructureObserver observer_;
  double match_s_ = 0.0;
  double information_s_ = 0.0;
};

// "Tracking starts" in schemas/definitions.md, of all six motions.
Matrix6d tracking_start_covariance();

// A match as a fit needs it, in the vehicle's true axes: motions from the true pose to the end of
// the match and to its start, and the evidence of structures at that end, unscaled.
struct MatchSample {
  Vector6d found = Vector6d::Zero();
  Vector6d start = Vector6d::Zero();
  StructureEvidence structure;
  double likelihood = 0.0;  // mean over scored points
  std::uint32_t point_count = 0;
  std::uint32_t scored_points = 0;
};

// What became of one scan. Errors are forward, left, yaw in the vehicle's true axes, m and rad.
struct LoopStep {
  std::string kind;
  bool is_matched = false;
  bool is_constrained[3] = {true, true, true};               // in truth, by axis
  Eigen::Vector3d match_error = Eigen::Vector3d::Zero();     // without the start, where it is known
  Eigen::Vector3d returned_error = Eigen::Vector3d::Zero();  // of the returned pose
  Eigen::Vector3d start_error = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of the match, as the filter used it
  Eigen::Matrix3d match_covariance = Eigen::Matrix3d::Zero();  // of the returned pose
  Eigen::Vector3d fused_error = Eigen::Vector3d::Zero();
  Eigen::Matrix3d fused_covariance = Eigen::Matrix3d::Zero();
  MatchSample sample;  // of structure sources
};

struct LoopOptions {
  CovarianceSource source = CovarianceSource::kStructure;
  InformationScale scale = default_information_scale();
  double rival_factor = 1.0;  // of the other sources' covariances
  double inflation = 5.0;     // of covariances that the filter is given, for correlated errors
  // Starts are drawn from this covariance instead of the filter's: of a vehicle that tracks.
  bool has_tracking_starts = false;
  std::uint64_t seed = 1;
};

// Drives with wheels (2 % off), gyro (0.02 degrees/s) and the localizer, whose starts are the
// filter's predictions.
std::vector<LoopStep> drive_closed_loop(WorldLocalizer& localizer, const TrueDrive& drive,
                                        const LoopOptions& options);

}  // namespace sightline
