#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "examples/town/drive/caster.h"
#include "examples/town/drive/drive_options.h"
#include "examples/town/drive/sensor.h"
#include "examples/town/drive/traffic.h"
#include "examples/town/whole/town.h"
#include "formats/drive/drive.h"
#include "formats/drive/sensor_profile.h"
#include "formats/geometry.h"

// Drives through a town: what a real recording would hold, and the truth that it would not.

namespace sightline::town {

// The same drive on foot: two scans a second, 0.7 m apart, and turns of 60 degrees between two.
DriveOptions carried_by_hand(DriveOptions options);

// The customary drives: 0 maps, 1 is 0.1 m to the left, 2 and later 0.3 m to the right; noise of
// 2.0, 2.25 and 2.5 cm. In a hard world the speed changes by 5 % and the range ends at 60 m.
DriveOptions usual_drive(const TownOptions& town, std::uint64_t drive, const SensorProfile& sensor);

struct TownScan {
  std::int64_t stamp_ns = 0;
  Pose T_town_vehicle = Pose::Identity();  // true; on the ground, not at the sensor
  std::vector<LabelledPoint> points;       // by azimuth, then by ring from below
  // When each was measured, ns after the stamp; empty: all at once.
  std::vector<std::int32_t> time_offset_ns = {};
};

// One drive, scan by scan: nothing is kept, so drives of any length fit into memory.
class DriveSimulator {
 public:
  // Keeps a reference to the town. Error: bad-argument where the options make no sense.
  static Result<DriveSimulator> make(const Town& town, const DriveOptions& options);

  [[nodiscard]] std::size_t scan_count() const { return poses_.size(); }
  [[nodiscard]] std::int64_t stamp_ns(std::size_t index) const;
  [[nodiscard]] double driven_m(std::size_t index) const;  // arc length of the driven line
  [[nodiscard]] const std::vector<Pose>& T_town_vehicle() const { return poses_; }  // true
  // At any time, true; of a drive that is swept.
  [[nodiscard]] Pose T_town_vehicle_at(double time_s) const;
  // As a good positioning system would report them: off by about 2 cm and 0.04 degrees, mostly
  // slowly varying.
  [[nodiscard]] std::vector<Pose> disturbed_poses() const;
  // The same whichever scans were asked for before. Safe from several threads.
  [[nodiscard]] TownScan scan(std::size_t index) const;
  // What moves at that scan, and all that stands still during the drive.
  [[nodiscard]] TownMesh moving_mesh_at(std::size_t index) const;
  [[nodiscard]] const TownCaster& standing() const { return *standing_; }
  [[nodiscard]] const SensorProfile& sensor() const { return options_.sensor; }

 private:
  DriveSimulator() = default;

  const Town* town_ = nullptr;
  DriveOptions options_;
  std::vector<Mover> movers_;
  std::vector<Pose> poses_;
  std::unique_ptr<TownCaster> standing_;
  std::unique_ptr<TownCaster> fog_;  // null: none
};

// A whole drive in memory with its labels, for tests.
std::vector<TownScan> simulate(const DriveSimulator& drive, int threads);

// The same as passes take it, with the poses given: true or disturbed ones. The world is the
// town's coordinates. Without turn rates.
Drive recorded(const DriveSimulator& drive, const std::string& name, std::span<const Pose> poses,
               int threads);

}  // namespace sightline::town
