#pragma once

#include <array>
#include <memory>
#include <vector>

#include "passes/matching/look_plan.h"
#include "tests/bench/mapped_town.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

namespace sightline {

// A mapped town and drives 1 and 2 through it.
struct DrivenTown {
  NdtMap map;
  SensorProfile sensor;
  std::array<TownDrive, 2> drives;
  Localizer of_samples;  // for looks that take a sample
  Localizer searching;   // for static 50 m
};
std::unique_ptr<DrivenTown> make_driven_town(const MappedTownOptions& options);

// Localizes one scan after another: a rule under comparison.
class Vehicle {
 public:
  virtual ~Vehicle() = default;
  virtual PlannedMatch localize(const Scan& scan, const PosePrediction& prediction) = 0;
};

// One look always; where it settles and the vehicle does not track, it searches.
std::unique_ptr<Vehicle> make_static_vehicle(const DrivenTown& town, const Look& look);
std::unique_ptr<Vehicle> make_planned_vehicle(const DrivenTown& town, const LookPlan& plan);

// One scan of a drive in closed loop.
struct DriveStep {
  double error_m = 0.0;
  bool is_tracking = false;
  bool is_lost = false;        // more than a metre off: it starts anew from outside
  double first_error_m = 0.0;  // of a plan's first look
  PlannedMatch found;
  double time_ms = -1.0;  // thread CPU time with cold caches; below 0: not measured
};

// A vehicle on a drive. It begins up to a metre off, as from outside, and predicts itself from its
// last two results: from the third scan on it tracks.
class ClosedLoop {
 public:
  ClosedLoop(const TownDrive& drive, Vehicle& vehicle) : drive_(drive), vehicle_(vehicle) {}
  DriveStep step(std::size_t scan, bool is_timed);

 private:
  PosePrediction predict(std::size_t scan);
  const TownDrive& drive_;
  Vehicle& vehicle_;
  Pose T_map_last_ = Pose::Identity();
  Pose motion_ = Pose::Identity();
  int found_count_ = 0;  // in a row
  std::size_t begun_count_ = 0;
};
std::vector<DriveStep> drive_whole(const TownDrive& drive, Vehicle& vehicle);

}  // namespace sightline
