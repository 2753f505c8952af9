#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/following/scan_before.h"
#include "passes/trajectory/following/speed_forecast.h"
#include "passes/trajectory/following/steady_motion.h"
#include "passes/trajectory/following/way_filter.h"
#include "passes/trajectory/local/estimate_options.h"
#include "passes/trajectory/local/local_map.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/scan_constraint.h"

namespace sightline {

// The standard deviation of a step that was only forecast.
inline constexpr double kNoConstraint_m = 100.0;

// Running means over the latest scans: a scan far below them was matched in a wrong place.
struct RunningAverage {
  double likelihood = 0.0;
  double scored_share = 0.0;
  double overlap = 0.0;

  void add(const LocalMatch& match, std::optional<double> scan_overlap);
  [[nodiscard]] bool is_met_by(const LocalMatch& match) const;
};

// A scan: thinned for matching and for the local map.
struct ReadScan {
  ThinnedScan thinned;
  std::vector<Eigen::Vector3d> upright_m;         // of to_match_m
  std::vector<Eigen::Vector3d> upright_to_map_m;  // of to_map_m
};
// Whether upright points are computed. They are needed where no given pose leads to a scan; where
// all scans have one, overlaps_along() computes them later.
enum class Upright { kLeftOut, kComputed };
// Errors: those of reading a scan.
Result<ReadScan> read_scan(const Drive& drive, std::size_t index, Upright upright);

// Follows a drive from scan to scan, by the rules of run_odometry.
class Follower {
 public:
  // Begins at scan `first`. Drive and poses must outlive it and its copies. `speed`: of the drive,
  // before its first step.
  Follower(const Drive& drive, const GivenPoses& given, double local_map_m, std::size_t first,
           const SpeedForecast& speed = {});

  void take(const ReadScan& scan);
  // Continues with a scan that was found by other means.
  void take_there(const ReadScan& scan, const LocalMatch& match);

  // Takes the first step of a piece, predicted by a step that was measured later.
  void begin_with(const ReadScan& scan, const TimedStep& step);
  // No motion where a piece just began.
  [[nodiscard]] TimedStep last_step() const;

  // Whether the next scan is the first step of a piece, whose motion is not known.
  [[nodiscard]] bool is_at_first_step() const;
  // Places of the scan of a first step: the good matches within 4 m, at most four, in order of
  // overlap.
  [[nodiscard]] std::vector<LocalMatch> first_steps(const ReadScan& scan) const;

  Odometry odometry;  // from the first scan on

 private:
  // The place that was found for a scan, with its overlap.
  struct Found {
    LocalMatch match;
    std::optional<double> overlap;
    double overlap_elsewhere = 0.0;
    bool is_believed = false;
    bool is_wide = false;     // not where even motion leads
    bool is_far = false;      // found by the search farther around
    bool is_carried = false;  // poor, and no search can be better: in a sparse place
  };

  // How far ahead of the forecast a fit is, and the standard deviation of its surfaces alone along
  // the road.
  struct FittedWay {
    double off_m = 0.0;
    double surfaces_sigma_m = 0.0;
  };

  // A pose, and what its scan does not constrain of it.
  struct Placed {
    Pose T_map_lidar = Pose::Identity();
    StepConstraint constraint;
    // Of a match whose way the surfaces constrain from the way that sensors measured, ahead.
    std::optional<double> off_measured_m;
    // Of a fit that used the forecast of a step at constant speed.
    std::optional<FittedWay> fitted_way = std::nullopt;
  };

  [[nodiscard]] const Pose& T_map_before() const { return odometry.T_map_lidar.back(); }
  [[nodiscard]] std::size_t next_scan() const { return first_ + odometry.T_map_lidar.size(); }
  [[nodiscard]] bool begins_part(std::size_t k) const;
  [[nodiscard]] bool has_given_step(std::size_t k) const;
  [[nodiscard]] std::int64_t step_ns(std::size_t k) const;
  [[nodiscard]] bool is_jump(std::size_t k) const;
  [[nodiscard]] std::vector<Pose> predictions(std::size_t k) const;
  [[nodiscard]] Pose moved_on(std::size_t k) const;

  // The vehicle's direction ahead, map axes.
  [[nodiscard]] Eigen::Vector3d along_road(const Pose& T_map_lidar) const;
  // How far ahead the scan before clearly shows this one instead.
  [[nodiscard]] std::optional<double> rival_m(std::size_t k, const ReadScan& scan,
                                              const Pose& T_map_lidar) const;
  [[nodiscard]] Found followed(std::size_t k, const ReadScan& scan) const;
  [[nodiscard]] Found follow_from(const std::vector<Pose>& starts, const ReadScan& scan) const;
  [[nodiscard]] bool is_poor(const Found& found) const;
  [[nodiscard]] Found find(std::size_t k, const ReadScan& scan) const;
  [[nodiscard]] Found find_widely(const LocalSurroundings& there, const SoughtScan& sought,
                                  const Found& followed) const;

  // A pose that no scan constrains.
  struct Forecasted {
    Pose T_map_lidar = Pose::Identity();
    Forecast source = Forecast::kNone;
    double way_share = 0.0;
    double way_sigma_m = 0.0;  // of a way that sensors measured
  };
  [[nodiscard]] ScanStep step_to_scan(std::size_t k, const Pose& T_map_lidar) const;
  [[nodiscard]] std::optional<Forecasted> forecast(std::size_t k) const;
  [[nodiscard]] PlanarMotion forecast_sigma_m(const Forecasted& by_forecast) const;
  [[nodiscard]] Pose with_forecast(const Pose& T_map_lidar, const Forecasted& by_forecast,
                                   const Eigen::Matrix3d& weak_part) const;
  [[nodiscard]] bool is_alarm(std::size_t k, const Pose& T_map_forecast,
                              const Pose& T_map_fitted) const;
  [[nodiscard]] double step_s(std::size_t k) const;
  // Whether a step takes so long that constant speed does not lead to where surfaces are met.
  [[nodiscard]] bool is_long_step(std::size_t k) const;
  // How far ahead of one pose of the sensor another one is, along the road.
  [[nodiscard]] double ahead_m(const Pose& T_map_from, const Pose& T_map_to) const;
  [[nodiscard]] Pose steady_step(std::size_t k) const;
  void take_way(std::size_t k, Placed& to);
  [[nodiscard]] Eigen::Vector2d leap_m(std::size_t k, const Placed& to, const Found& found) const;
  // A match, and the standard deviation from which on its motions are fitted instead.
  struct FitAbove {
    const ScanConstraint& by_match;
    double sigma_m = 0.0;
  };
  [[nodiscard]] Placed fitted(std::size_t k, const ReadScan& scan, const Pose& T_map_matched,
                              const Forecasted& by_forecast, const FitAbove& few) const;
  [[nodiscard]] Placed placed(std::size_t k, const ReadScan& scan, const Pose& T_map_matched) const;
  [[nodiscard]] bool is_map_thick() const;
  [[nodiscard]] bool is_sparse(std::size_t k) const;
  [[nodiscard]] Placed placed_or_carried(std::size_t k, const ReadScan& scan,
                                         const Found& found) const;
  [[nodiscard]] bool fits_given_better(const ReadScan& scan, const Pose& T_map_matched,
                                       const Pose& T_map_given) const;

  void follow_with_given(std::size_t k, const ReadScan& scan);
  void follow_alone(std::size_t k, const ReadScan& scan);
  void step_to(std::size_t k, const ReadScan& scan, const Found& found);
  void begin_piece(const PieceStart& start);
  void append(const Pose& T_map_lidar, bool is_matched, std::optional<double> overlap);
  void remember(const ReadScan& scan);

  const Drive* drive_;
  const GivenPoses* given_;
  double local_map_m_;
  std::size_t first_;  // scan
  std::int64_t longest_step_ns_;
  LocalMap map_;
  UprightMap upright_;
  RunningAverage average_;
  std::vector<TimedStep> steps_;  // that may continue
  SteadyMotion steady_;
  std::optional<TimedStep> last_sound_;  // the last step that scans constrain, without a leap
  std::int64_t since_sound_ns_ = 0;
  std::size_t held_steps_ = 0;  // in a row, whose way scans constrain
  WayFilter way_;               // predicted up to the next scan while that is placed
  SpeedForecast speed_;
  WayCheck way_check_;
  ScanBefore before_;
  std::vector<Eigen::Vector3d> before_m_;  // the last scan's to_map_m; where its pose is given
  bool was_found_widely_ = false;
  bool is_map_empty_ = true;
  double piece_began_m_ = 0.0;  // of the way driven
};

}  // namespace sightline
