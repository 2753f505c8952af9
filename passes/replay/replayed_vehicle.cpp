#include "passes/replay/replayed_vehicle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/stopwatch.h"
#include "passes/matching/match_starts.h"
#include "passes/replay/pose_rows.h"
#include "passes/replay/straighten.h"
#include "passes/trajectory/local/local_match.h"

// Why a check of its own, beside the plan's doubt: the doubt compares a match with the forecast it
// began at, and a vehicle that is lost has forecasts that agree with its wrong matches. Streets
// differ in upright surfaces, and a look of some dozen points has few of these; so the whole scan
// is compared, which takes as long as some matches, at every tenth scan.

namespace sightline {
namespace {

// A pause after which the last speed no longer predicts the pose.
constexpr std::int64_t kLongestStep_ns = 2'000'000'000;
constexpr std::size_t kCheckEvery = 10;
// So many scans in a row that contradict the map: a lorry beside the vehicle hides walls for less.
constexpr int kMostContradictions = 3;
constexpr double kReach_m = 3.0;
// Share of upright returns that meet the map: 0.35 in a sparse map of a real street and 0.95 in a
// generated one; below 0.02 in another real street, to 0.35 in another generated town. So what is
// usual of a drive decides, once it is known.
constexpr double kLeastMetAtStart = 0.36;
constexpr double kLeastOfUsual = 0.55;
constexpr double kNewestWeight = 0.2;  // of the usual share: the mean of some five checks
// Behind the first five, every fifth scan is searched for: its neighbours fail alike.
constexpr int kSearchEvery = 5;

double mean_score(const sightline_match& match) {
  return match.score / std::max(1.0, static_cast<double>(match.point_count));
}

ReplayedScan replayed(const Matched& matched) {
  ReplayedScan scan;
  scan.state = ScanState::kLocalized;
  scan.T_world_vehicle = pose_of(matched.match.T_world_vehicle);
  scan.covariance = Eigen::Map<const Matrix6d>(matched.match.covariance);
  scan.look = matched.look;
  scan.look_count = matched.match.look_count;
  scan.point_count = matched.match.point_count;
  scan.weak = matched.match.weak;
  return scan;
}

// The start itself, then those around it.
std::vector<Pose> starts_from(const Pose& T_world_start) {
  std::vector<Pose> starts = {T_world_start};
  for (const Pose& start : starts_around(T_world_start, kReach_m)) starts.push_back(start);
  return starts;
}

Result<std::vector<Eigen::Vector3d>> route_of(const MapReader& map) {
  SIGHTLINE_ASSIGN(const std::vector<MapSite> sites, map.sites(0));
  std::vector<Eigen::Vector3d> route_world_m;
  route_world_m.reserve(sites.size());
  for (const MapSite& site : sites) {
    route_world_m.emplace_back(Eigen::Map<const Eigen::Vector3d>(site.position_world_m.data()));
  }
  return route_world_m;
}

}  // namespace

// Of the present map: one that was made sparser is met less.
double ReplayedVehicle::usual_met() const {
  return usual_map_ == inputs_.maps.present() ? usual_met_ : 0.0;
}

double ReplayedVehicle::least_met() const {
  return usual_met() > 0.0 ? kLeastOfUsual * usual_met() : kLeastMetAtStart;
}

double ReplayedVehicle::limit_m() const {
  return options_.limit_m > 0.0 ? options_.limit_m : reader().info().limits_m.front();
}

std::optional<double> ReplayedVehicle::met_share(const std::vector<Eigen::Vector3d>& upright_m,
                                                 const Pose& T_world_vehicle) const {
  return inputs_.maps.in_memory().check.met_share(upright_m, T_world_vehicle);
}

std::optional<Pose> ReplayedVehicle::given(std::size_t number) const {
  if (options_.starts_from_nothing) return std::nullopt;
  return inputs_.scans[number].T_world_vehicle;
}

Pose ReplayedVehicle::predicted(std::int64_t step_ns) const {
  const double factor =
      last_step_ns_ > 0 ? static_cast<double>(step_ns) / static_cast<double>(last_step_ns_) : 0.0;
  return predicted_pose(*T_world_last_, T_before_last_, factor);
}

// From outside where there is anything, else where the vehicle was last.
std::optional<Pose> ReplayedVehicle::start_of(std::size_t number) const {
  if (!has_started_ && options_.T_world_start) return options_.T_world_start;
  if (given(number)) return given(number);
  if (!T_world_last_) return std::nullopt;
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  return step_ns <= kLongestStep_ns ? predicted(step_ns) : *T_world_last_;
}

// By where the vehicle is expected.
Result<void> ReplayedVehicle::choose_map(std::size_t number) {
  const std::optional<Pose> expected =
      tracks() ? predicted(inputs_.scans[number].stamp_ns - last_ns_) : start_of(number);
  if (!expected) return inputs_.maps.stay();
  return inputs_.maps.go_to(*expected * inputs_.sensor.T_vehicle_lidar.translation(), tracks());
}

Result<Matched> ReplayedVehicle::match(const Scan& scan, const Pose& T_world_start,
                                       bool is_tracking) const {
  const Eigen::Vector3d sensor_m = T_world_start * inputs_.sensor.T_vehicle_lidar.translation();
  LookPlanAnswer plan;
  if (options_.every_return_m) {
    plan.first.look.range_m = *options_.every_return_m;
  } else {
    SIGHTLINE_ASSIGN(plan, reader().look_plan({sensor_m.x(), sensor_m.y(), sensor_m.z()}, limit_m(),
                                              is_tracking));
  }
  if (!is_tracking) plan.first.look.settles = false;
  SIGHTLINE_ASSIGN(const sightline_match match, inputs_.maps.in_memory().localizer.match(
                                                    points_of(scan), rows_of(T_world_start), plan));
  return Matched{match, match.look_count > 1 ? plan.second : plan.first.look};
}

void ReplayedVehicle::found(const Pose& T_world_vehicle, bool follows) {
  has_started_ = true;
  search_count_ = 0;
  if (follows) T_before_last_ = T_world_last_->inverse(Eigen::Isometry) * T_world_vehicle;
  if (!follows) T_before_last_ = Pose::Identity();
  T_world_last_ = T_world_vehicle;
  ++result_count_;
}

void ReplayedVehicle::shown(double met_share) {
  const double usual = usual_met();
  usual_met_ = usual > 0.0 ? usual + kNewestWeight * (met_share - usual) : met_share;
  usual_map_ = inputs_.maps.present();
}

void ReplayedVehicle::lose() {
  result_count_ = 0;
  contradiction_count_ = 0;
  ++lost_count_;
}

// One pose does not predict the next: the recording's poses say how far the vehicle moved, else it
// is up to 30 m/s ahead, or slowly behind.
std::vector<Pose> ReplayedVehicle::second_starts(std::size_t number) const {
  const std::optional<Pose> before = given(number - 1);
  const std::optional<Pose> now = given(number);
  const bool was_before = last_ns_ == inputs_.scans[number - 1].stamp_ns;
  if (before && now && was_before) {
    return {*T_world_last_ * (before->inverse(Eigen::Isometry) * *now)};
  }
  std::vector<Pose> starts;
  for (const double ahead_m : {0.0, 1.0, 2.0, 3.0, -1.0}) {
    starts.push_back(*T_world_last_ * Eigen::Translation3d(ahead_m, 0.0, 0.0));
  }
  return starts;
}

// By the last two poses or, behind the first one, the best of several starts.
Result<Matched> ReplayedVehicle::match_next(std::size_t number, const Scan& scan) const {
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  if (result_count_ > 1) return match(scan, predicted(step_ns), true);
  std::optional<Matched> best;
  for (const Pose& start : second_starts(number)) {
    SIGHTLINE_ASSIGN(const Matched matched, match(scan, start, false));
    if (!best || mean_score(matched.match) > mean_score(best->match)) best = matched;
  }
  return *best;
}

Result<ReplayedScan> ReplayedVehicle::follow(std::size_t number, const Scan& scan) {
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  SIGHTLINE_ASSIGN(const Matched matched, match_next(number, scan));
  ReplayedScan result = replayed(matched);
  const bool is_doubted = matched.match.look_count > 1 || !has_matched(matched.match);
  const bool is_new_map = usual_met() == 0.0;
  if (is_doubted || contradiction_count_ > 0 || until_check_ == 0 || is_new_map) {
    const std::optional<double> share =
        met_share(upright_of(scan, inputs_.sensor), result.T_world_vehicle);
    const bool contradicts = !has_matched(matched.match) || (share && *share < least_met());
    if (share && !contradicts) shown(*share);
    contradiction_count_ = contradicts ? contradiction_count_ + 1 : 0;
    until_check_ = kCheckEvery;
  }
  --until_check_;
  result.is_in_doubt = is_doubted || contradiction_count_ > 0;
  if (contradiction_count_ >= kMostContradictions) {
    result.state = ScanState::kLost;
    lose();
    return result;
  }
  found(result.T_world_vehicle, true);
  last_step_ns_ = step_ns;
  last_ns_ = inputs_.scans[number].stamp_ns;
  return result;
}

// Where no pose is known from outside.
bool ReplayedVehicle::searches(std::size_t number) {
  if (given(number) || (!has_started_ && options_.T_world_start)) return false;
  const int count = search_count_++;
  return count < kSearchEvery || count % kSearchEvery == 0;
}

Result<FoundHere> ReplayedVehicle::found_near(const Scan& scan,
                                              const std::vector<Eigen::Vector3d>& upright_m,
                                              const Pose& T_world_start) const {
  FoundHere best;
  for (const Pose& start : starts_from(T_world_start)) {
    SIGHTLINE_ASSIGN(const Matched matched, match(scan, start, false));
    const ReplayedScan result = replayed(matched);
    const double share = met_share(upright_m, result.T_world_vehicle).value_or(0.0);
    if (!has_matched(matched.match) || share <= best.met_share) continue;
    best = {result, share};
    if (share >= least_met()) break;
  }
  return best;
}

MapLook ReplayedVehicle::look_of_search() const {
  MapLook look;
  look.range_m = reader().info().ranges_m.back();
  return look;
}

// In the whole present map.
Result<std::optional<FoundPlace>> ReplayedVehicle::place_in_map(
    const Scan& scan, const std::vector<Eigen::Vector3d>& upright_m) const {
  MapInMemory& map = inputs_.maps.in_memory();
  if (!map.finder) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> route_world_m, route_of(reader()));
    map.finder.emplace(map.check.map(), route_world_m, inputs_.sensor.T_vehicle_lidar);
  }
  return find_place({map.localizer, map.check, *map.finder, look_of_search()}, scan, upright_m,
                    threads_);
}

// In all maps. Nothing is found where another place, of any of them, shows nearly as much of the
// scan.
Result<FoundHere> ReplayedVehicle::found_anywhere(
    const Scan& scan, const std::vector<Eigen::Vector3d>& upright_m) const {
  JoinedMaps& maps = inputs_.maps;
  const std::size_t present = maps.present();
  std::optional<FoundPlace> best;
  std::size_t best_map = present;
  for (std::size_t i = 0; i < maps.count(); ++i) {
    if (!maps.go_to(i)) continue;
    SIGHTLINE_ASSIGN(const std::optional<FoundPlace> place, place_in_map(scan, upright_m));
    if (!place) continue;
    if (!best || place->likelihood > best->likelihood) best_map = i;
    best = best ? likelier_of(*best, *place) : *place;
  }
  const bool is_found = best && is_sure(*best);
  SIGHTLINE_TRY(maps.go_to(is_found ? best_map : present));
  if (!is_found) return FoundHere();
  return FoundHere{replayed({best->match, look_of_search()}), best->met_share};
}

// Around a pose that is known from outside, and then, or where there is none, in all maps.
Result<ReplayedScan> ReplayedVehicle::begin(std::size_t number, const Scan& scan) {
  const std::vector<Eigen::Vector3d> upright_m = upright_of(scan, inputs_.sensor);
  const std::optional<Pose> T_world_start = start_of(number);
  FoundHere best;
  if (T_world_start) {
    SIGHTLINE_ASSIGN(best, found_near(scan, upright_m, *T_world_start));
  }
  if (best.met_share < least_met() && searches(number)) {
    SIGHTLINE_ASSIGN(best, found_anywhere(scan, upright_m));
  }
  ReplayedScan result = best.scan;
  result.begins = true;
  if (best.met_share < least_met()) {
    result.state = ScanState::kLost;
    result.has_pose = T_world_start.has_value();
    result.T_world_vehicle = T_world_start.value_or(Pose::Identity());
    return result;
  }
  shown(best.met_share);
  found(result.T_world_vehicle, false);
  last_step_ns_ = 0;
  last_ns_ = inputs_.scans[number].stamp_ns;
  until_check_ = kCheckEvery;
  return result;
}

Result<ReplayedScan> ReplayedVehicle::take(std::size_t number, Scan scan) {
  const std::int64_t step_ns = inputs_.scans[number].stamp_ns - last_ns_;
  if (tracks() && step_ns > kLongestStep_ns) result_count_ = 0;
  SIGHTLINE_TRY(choose_map(number));
  const double begin_ms = process_cpu_ms();
  const VehicleMotion motion = {T_before_last_, tracks() ? last_step_ns_ : 0};
  straighten(scan, motion, inputs_.sensor.T_vehicle_lidar);
  Result<ReplayedScan> result = tracks() ? follow(number, scan) : begin(number, scan);
  if (!result) return result;
  result->time_ms = process_cpu_ms() - begin_ms;
  result->map = inputs_.maps.present();
  return result;
}

}  // namespace sightline
