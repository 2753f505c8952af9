#include <cmath>

#include "formats/base/units.h"
#include "passes/trajectory/following/follower.h"
#include "passes/trajectory/local/scan_constraint.h"
#include "passes/trajectory/local/structure_fit.h"

// What a scan does not constrain of its pose, and what is used instead.

namespace sightline {
namespace {

// In a sparse place, a match farther from the forecast is not believed.
constexpr double kNearForecast_m = 0.5;
// A local map of fewer scans constrains matches less than the place does.
constexpr double kThinMap_m = 10.0;
// Surfaces are mapped by the scans before this one, so that their errors are those of many scans:
// standard deviations of surfaces count so many times beside the speed.
constexpr double kSharedErrors = 2.0;
// Above this, doubled, the speed is not changed: where nothing holds a scan, noise of surfaces
// seems to, by some centimetres, and would carry the speed away.
constexpr double kMeasuresNothing_m = 0.075;
// Where another axis is as weak, a fit turns what it cannot place into way.
constexpr double kOtherAxes = 0.5;
// As many as the mean speed is of.
constexpr std::size_t kHeldSteps = 10;
// Of a match that many surfaces hold.
constexpr double kLeastMatch_m = 0.01;
// A shorter mean step has no direction.
constexpr double kLeastSteady_m = 0.1;
// Of a step at constant speed: a fixed part of its standard deviation, and that across the road and
// of the heading as a share of the step.
constexpr double kLeastForecast_m = 0.003;
constexpr double kAsideShare = 0.1;
// In a longer step a driver who brakes moves a forecast off by more than the speed's filter allows
// (0.15 m; 2 m/s2).
constexpr double kLongStep_s = 0.387;
// Cars brake and accelerate less; a fit to few surfaces is accurate to about the first.
constexpr double kFitNoise_m = 0.02;
constexpr double kMostAcceleration_m_s2 = 6.0;
// Behind a stretch that few surfaces hold, matches move by up to 0.2 m to where these are again.
constexpr double kMapNoise_m = 0.2;

// Above this standard deviation of a match, few surfaces hold it, and it is off by centimetres: in
// curves of car parks it is up to 9 mm, where a match is right to millimetres.
constexpr double kFewSurfaces_m = 0.01;

// Of a match along the road.
double sigma_along_m(const ScanConstraint& constraint) {
  return constraint.motions.row(0).transpose().cwiseProduct(constraint.sigma_m).norm();
}

}  // namespace

ScanStep Follower::step_to_scan(std::size_t k, const Pose& T_map_lidar) const {
  return {drive_->scans[k - 1].stamp_ns, drive_->scans[k].stamp_ns, T_map_before(), T_map_lidar};
}

// The pose without any match: by the given step, else at the last speed that scans constrained, or
// at that of the vehicle's own sensors.
std::optional<Follower::Forecasted> Follower::forecast(std::size_t k) const {
  if (has_given_step(k)) {
    const Pose step = (*given_)[k - 1]->inverse() * *(*given_)[k];
    return Forecasted{tidied(T_map_before() * step), Forecast::kGiven, 0.0};
  }
  const std::optional<SpeedForecast::Way> way = speed_.way(step_to_scan(k, T_map_before()));
  if (!way && !steady_.is_known()) return std::nullopt;
  Pose step = steady_.is_known() ? steady_step(k) : Pose::Identity();
  if (!way) return Forecasted{tidied(T_map_before() * step), Forecast::kSteady, kSteadyShare};
  step.translation() = way->moved_m;
  return Forecasted{tidied(T_map_before() * step), way->source, way->share, way->sigma_m};
}

double Follower::step_s(std::size_t k) const {
  return static_cast<double>(step_ns(k)) / static_cast<double>(kSecond_ns);
}

bool Follower::is_long_step(std::size_t k) const { return step_s(k) > kLongStep_s; }

double Follower::ahead_m(const Pose& T_map_from, const Pose& T_map_to) const {
  const Pose T_lidar_vehicle = drive_->sensor.T_vehicle_lidar.inverse();
  return planar_motion(T_map_from * T_lidar_vehicle, T_map_to * T_lidar_vehicle).x();
}

// The mean of the last constrained steps, at the present speed.
Pose Follower::steady_step(std::size_t k) const {
  Pose step = steady_.step(step_ns(k));
  const double mean_m = ahead_m(T_map_before(), T_map_before() * step);
  if (way_.is_known() && std::abs(mean_m) > kLeastSteady_m) {
    step.translation() *= way_.way_m(step_s(k)) / mean_m;
  }
  return step;
}

// The speed is filtered from the first step that rests on constant speed until ten steps in a row
// are constrained. It begins with the mean of the steps before.
void Follower::take_way(std::size_t k, Placed& to) {
  const bool is_weak = to.constraint.weak[0] > 0.0 && to.constraint.forecast == Forecast::kSteady;
  held_steps_ = is_weak ? 0 : held_steps_ + 1;
  if (held_steps_ >= kHeldSteps) way_ = {};
  if (step_ns(k) <= 0) return;
  if (!way_.is_known()) {
    if (!is_weak || !steady_.is_known()) return;
    const Pose step = steady_.step(step_ns(k));
    return way_.begin(ahead_m(T_map_before(), T_map_before() * step) / step_s(k));
  }
  if (to.fitted_way) {
    const FittedWay& fitted = *to.fitted_way;
    const bool is_alone = to.constraint.weak[1] < kOtherAxes && to.constraint.weak[2] < kOtherAxes;
    if (!is_alone || fitted.surfaces_sigma_m > kMeasuresNothing_m) return;
    if (way_.take_estimate(fitted.off_m, fitted.surfaces_sigma_m)) to.constraint.kept[0] = 1.0;
    return;
  }
  if (to.constraint.forecast != Forecast::kNone) return;
  const double off_m = ahead_m(T_map_before(), to.T_map_lidar) - way_.way_m(step_s(k));
  way_.take_measurement(off_m, std::max(kLeastMatch_m, to.constraint.sigma_m));
}

// Standard deviations of a step that is forecast.
PlanarMotion Follower::forecast_sigma_m(const Forecasted& by_forecast) const {
  const double step_m =
      (by_forecast.T_map_lidar.translation() - T_map_before().translation()).norm();
  const double aside_m = kLeastForecast_m + kAsideShare * step_m;
  if (by_forecast.source == Forecast::kSteady && way_.is_known()) {
    return {way_.sigma_m() / kSharedErrors, aside_m, aside_m};
  }
  return {kLeastForecast_m + by_forecast.way_share * step_m, aside_m, aside_m};
}

// Moves a pose to what was forecast of the motions that scans do not constrain.
Pose Follower::with_forecast(const Pose& T_map_lidar, const Forecasted& by_forecast,
                             const Eigen::Matrix3d& weak_part) const {
  const Pose& T_vehicle_lidar = drive_->sensor.T_vehicle_lidar;
  const Pose T_lidar_vehicle = T_vehicle_lidar.inverse();
  const Pose T_map_vehicle = T_map_lidar * T_lidar_vehicle;
  const PlanarMotion off = planar_motion(T_map_vehicle, by_forecast.T_map_lidar * T_lidar_vehicle);
  const PlanarMotion weak = weak_part * off;
  return moved_in_plane(T_map_vehicle, weak) * T_vehicle_lidar;
}

// Whether a fit along the road needs a change of speed that no vehicle has.
bool Follower::is_alarm(std::size_t k, const Pose& T_map_forecast, const Pose& T_map_fitted) const {
  const double change_m = ahead_m(T_map_forecast, T_map_fitted);
  return std::abs(change_m) > kFitNoise_m + kMostAcceleration_m_s2 * step_s(k) * step_s(k);
}

// How far a constrained match is from the last sound motion, where a vehicle would have to change
// its speed more than it can; else zero. Many surfaces may hold a scan in a wrong place, or the map
// is wrong: this step is wrong or makes up for wrong ones. Not where a wide search, which compares
// with other places, found the scan.
Eigen::Vector2d Follower::leap_m(std::size_t k, const Placed& to, const Found& found) const {
  const bool is_by_scans = to.constraint.weak.isZero(0.0) && !has_given_step(k);
  if (!is_by_scans || found.is_wide || !last_sound_ || !steady_.is_known() || step_ns(k) <= 0) {
    return Eigen::Vector2d::Zero();
  }
  if (speed_.way(step_to_scan(k, T_map_before()))) return Eigen::Vector2d::Zero();
  const Pose T_lidar_vehicle = drive_->sensor.T_vehicle_lidar.inverse();
  const Pose T_map_even = T_map_before() * carried_on(*last_sound_, step_ns(k));
  const Eigen::Vector2d off_m =
      planar_motion(T_map_even * T_lidar_vehicle, to.T_map_lidar * T_lidar_vehicle).head<2>();
  const double time_s =
      static_cast<double>(since_sound_ns_ + step_ns(k)) / static_cast<double>(kSecond_ns);
  const double most_m = kMapNoise_m + kMostAcceleration_m_s2 * time_s * step_s(k);
  if (off_m.norm() <= most_m) return Eigen::Vector2d::Zero();
  return off_m;
}

// A scan that few surfaces hold, by those and by the forecast. A match there is where the rings of
// this scan meet those of the last ones.
Follower::Placed Follower::fitted(std::size_t k, const ReadScan& scan, const Pose& T_map_matched,
                                  const Forecasted& by_forecast, const FitAbove& few) const {
  const Pose T_lidar_vehicle = drive_->sensor.T_vehicle_lidar.inverse();
  const RollingCells* const grids[] = {&map_.details(), &map_.grids().fine_cells()};
  const std::vector<Eigen::Vector3d>& points_m = scan.thinned.to_map_m;
  Eigen::Matrix3d weak_part = few.by_match.weak_part(few.sigma_m);
  FitStart start{with_forecast(T_map_matched, by_forecast, weak_part),
                 few.by_match.weak_motions(few.sigma_m), forecast_sigma_m(by_forecast)};
  Placed to{tidied(fit_structure(grids, points_m, start, T_lidar_vehicle)), {}, {}};
  const ScanConstraint constraint = scan_constraint(
      met_surfaces(grids, points_m, to.T_map_lidar, T_lidar_vehicle), HoldRule::kClear);
  to.constraint.sigma_m = constraint.sigma_m[0];
  to.constraint.kept = kept_shares(constraint);
  // Surfaces that are met near a wrong forecast are other ones.
  if (is_long_step(k)) to.constraint.kept[0] = 1.0;
  const FittedWay way{ahead_m(start.T_map_lidar, to.T_map_lidar),
                      kSharedErrors * sigma_along_m(constraint)};
  const bool is_steady = by_forecast.source == Forecast::kSteady && way_.is_known();
  const bool is_contradicted = is_steady && way.surfaces_sigma_m <= kMeasuresNothing_m &&
                               way_.is_contradicted(way.off_m, way.surfaces_sigma_m);
  if (is_contradicted || is_alarm(k, start.T_map_lidar, to.T_map_lidar)) {
    to.fitted_way = FittedWay{0.0, kNoConstraint_m};
    to.T_map_lidar = tidied(start.T_map_lidar);
    to.constraint.weak = few.by_match.weak_axes(few.sigma_m);
  } else {
    to.constraint.weak = constraint.weak_axes(kWeak_m);
    weak_part = constraint.weak_part(kWeak_m);
    to.fitted_way = way;
  }
  if (to.constraint.weak.isZero(0.0)) return to;
  to.constraint.forecast = by_forecast.source;
  to.constraint.way_share = by_forecast.way_share;
  to.constraint.forecast_motions = weak_part;
  return to;
}

// A matched pose; what the scan does not constrain of it is as forecast.
Follower::Placed Follower::placed(std::size_t k, const ReadScan& scan,
                                  const Pose& T_map_matched) const {
  const Pose T_lidar_vehicle = drive_->sensor.T_vehicle_lidar.inverse();
  const ScanConstraint constraint = scan_constraint(
      met_surfaces(map_.grids(), scan.thinned.to_match_m, T_map_matched, T_lidar_vehicle));
  Placed to{T_map_matched, {constraint.sigma_m[0], constraint.weak_axes(kWeak_m)}, {}};
  to.constraint.kept = kept_shares(constraint);
  const std::optional<Forecasted> by_forecast = forecast(k);
  if (!by_forecast) return to;
  if (by_forecast->source == Forecast::kSteady) {
    const bool jumps = is_alarm(k, by_forecast->T_map_lidar, T_map_matched);
    const double few_m = jumps ? kSparse_m : is_long_step(k) ? kWeak_m : kFewSurfaces_m;
    if (constraint.has_weak(few_m)) {
      const FitAbove above{constraint, few_m};
      return fitted(k, scan, T_map_matched, *by_forecast, above);
    }
  }
  const bool is_measured = is_map_thick() && (by_forecast->source == Forecast::kWheels ||
                                              by_forecast->source == Forecast::kInertial);
  const double most_m = has_given_step(k) || is_measured ? kWeakBesideGiven_m : kWeak_m;
  if (is_measured) to.constraint.weak = constraint.weak_axes(most_m);
  const double off_m =
      planar_motion(T_map_matched * T_lidar_vehicle, by_forecast->T_map_lidar * T_lidar_vehicle)
          .x();
  Eigen::Matrix3d weak_part = constraint.weak_part(most_m);
  if (is_measured && to.constraint.weak[0] == 0.0) {
    to.off_measured_m = -off_m;
    if (constraint.has_weak(kSparse_m) && way_check_.refutes(-off_m, by_forecast->way_sigma_m)) {
      to.constraint.weak[0] = 1.0;
      weak_part.setZero();
      weak_part(0, 0) = 1.0;
    }
  }
  if (to.constraint.weak.isZero(0.0) && !constraint.has_weak(most_m)) return to;
  to.constraint.forecast = by_forecast->source;
  to.constraint.way_share = by_forecast->way_share;
  to.constraint.forecast_motions = weak_part;
  to.T_map_lidar = tidied(with_forecast(T_map_matched, *by_forecast, weak_part));
  return to;
}

bool Follower::is_map_thick() const {
  return odometry.driven_m.back() - piece_began_m_ >= kThinMap_m;
}

// Whether few surfaces held the last scan, and its motion may go on: then neither an overlap nor a
// wide search is evidence, and a piece begun here would know less.
bool Follower::is_sparse(std::size_t k) const {
  if (is_jump(k) || odometry.constraint.back().sigma_m <= kSparse_m) return false;
  return steady_.is_known() || (is_map_thick() && forecast(k).has_value());
}

// In a sparse place: where the match ends near the forecast, as placed(); else the forecast alone.
Follower::Placed Follower::placed_or_carried(std::size_t k, const ReadScan& scan,
                                             const Found& found) const {
  const Forecasted by_forecast = *forecast(k);
  if (found.match.is_good()) {
    const Placed to = placed(k, scan, found.match.T_map_lidar);
    if (planar_motion(to.T_map_lidar, by_forecast.T_map_lidar).norm() < kNearForecast_m) return to;
  }
  return {by_forecast.T_map_lidar,
          {kNoConstraint_m, Eigen::Vector3d::Ones(), by_forecast.source,
           Eigen::Matrix3d::Identity(), by_forecast.way_share, Eigen::Vector3d::Ones()},
          {}};
}

}  // namespace sightline
