#include "tests/bench/driving/driven_town.h"
#include "tests/bench/bench_tools.h"

#include <utility>

#include "formats/base/stopwatch.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

class StaticVehicle : public Vehicle {
 public:
  StaticVehicle(const DrivenTown& town, const Look& look)
      : look_(look),
        localizer_(takes_every_return(look) ? town.searching : town.of_samples),
        sensor_(town.sensor) {
    if (!takes_every_return(look)) options_.stop_step_m = kSampleStop_m;
  }

  PlannedMatch localize(const Scan& scan, const PosePrediction& prediction) override {
    const Pose& T_map_start = prediction.T_map_vehicle;
    cutter_.cut(localizer_, scan, sensor_, look_, T_map_start, cut_);
    PlannedMatch result;
    result.look_count = 1;
    result.match = look_.mode == LookMode::kSettle && prediction.is_tracking
                       ? settle(localizer_, cut_, T_map_start, options_)
                       : sightline::localize(localizer_, cut_, T_map_start, options_);
    return result;
  }

 private:
  Look look_;
  const Localizer& localizer_;
  const SensorProfile& sensor_;
  MatchOptions options_;
  LookCutter cutter_;
  ScanForMatch cut_;
};

class PlannedVehicle : public Vehicle {
 public:
  PlannedVehicle(const DrivenTown& town, const LookPlan& plan)
      : plan_(plan), planned_{town.of_samples, town.sensor, plan_} {}

  PlannedMatch localize(const Scan& scan, const PosePrediction& prediction) override {
    return localize_in_looks(planned_, scan, prediction, memory_);
  }

 private:
  LookPlan plan_;
  PlannedLocalizer planned_;
  LookMemory memory_;
};

}  // namespace

std::unique_ptr<DrivenTown> make_driven_town(const MappedTownOptions& options) {
  auto town = std::make_unique<DrivenTown>();
  MappedTown mapped = make_mapped_town(options);
  town->map = std::move(mapped.map);
  town->sensor = mapped.sensor;
  town->drives[0] = drive_through_town(options, 1, mapped.sensor);
  town->drives[1] = {std::move(mapped.scans), std::move(mapped.T_map_vehicle)};
  town->of_samples = make_localizer(town->map, options_for_samples());
  town->searching = make_localizer(town->map, localizer_options(LocalizerKind::kSearching));
  return town;
}

std::unique_ptr<Vehicle> make_static_vehicle(const DrivenTown& town, const Look& look) {
  return std::make_unique<StaticVehicle>(town, look);
}

std::unique_ptr<Vehicle> make_planned_vehicle(const DrivenTown& town, const LookPlan& plan) {
  return std::make_unique<PlannedVehicle>(town, plan);
}

PosePrediction ClosedLoop::predict(std::size_t scan) {
  if (found_count_ > 0) return {predicted_pose(T_map_last_, motion_), found_count_ >= 2};
  static const std::vector<InitialOffset> kOffsets = initial_offsets(StartPattern{});
  const Pose& T_map_true = drive_.T_map_vehicle[scan];
  motion_ = Pose::Identity();
  if (scan > 0) motion_ = drive_.T_map_vehicle[scan - 1].inverse(Eigen::Isometry) * T_map_true;
  return {T_map_true * start_pose(kOffsets[begun_count_++ % kOffsets.size()]), false};
}

DriveStep ClosedLoop::step(std::size_t scan, bool is_timed) {
  const PosePrediction prediction = predict(scan);
  DriveStep step;
  step.is_tracking = prediction.is_tracking;
  if (is_timed) empty_caches();
  const double begin_ms = is_timed ? thread_cpu_ms() : 0.0;
  step.found = vehicle_.localize(drive_.scans[scan], prediction);
  if (is_timed) step.time_ms = thread_cpu_ms() - begin_ms;
  const Pose& T_map_found = step.found.match.T_map_sensor;
  const Eigen::Vector3d true_m = drive_.T_map_vehicle[scan].translation();
  step.error_m = (T_map_found.translation() - true_m).norm();
  step.first_error_m = (step.found.T_map_first.translation() - true_m).norm();
  if (found_count_ > 0) motion_ = T_map_last_.inverse(Eigen::Isometry) * T_map_found;
  T_map_last_ = T_map_found;
  step.is_lost = step.error_m > 1.0;
  found_count_ = step.is_lost ? 0 : found_count_ + 1;
  return step;
}

std::vector<DriveStep> drive_whole(const TownDrive& drive, Vehicle& vehicle) {
  ClosedLoop loop(drive, vehicle);
  std::vector<DriveStep> steps;
  for (std::size_t scan = 0; scan < drive.scans.size(); ++scan) {
    steps.push_back(loop.step(scan, false));
  }
  return steps;
}

}  // namespace sightline
