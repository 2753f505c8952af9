#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "examples/town/caster.h"
#include "examples/town/sensor.h"
#include "examples/town/town.h"
#include "examples/town/traffic.h"
#include "formats/drive/drive.h"
#include "formats/drive/sensor_profile.h"
#include "formats/geometry.h"

// Drives through a town: what a real recording would hold, and the truth that it would not.

namespace sightline::town {

struct DriveOptions {
  std::uint64_t drive = 0;  // 0 maps; each number is another day with other cars and people
  double from_m = 0.0;      // of the driven line, where the drive begins
  double length_m = 600.0;  // from there on; at most to the town's end, twice that around a block
  double spacing_m = 1.0;   // between scans
  double lateral_m = 0.0;   // to the left of the driven line
  // In the oncoming lane where the street has one, else on the line: from one to the other within
  // 20 m. No oncoming cars then.
  bool is_in_next_lane = false;
  bool is_back = false;  // from the end to the beginning, facing there
  double yaw_rad = 0.0;  // how far the vehicle points to the left of it
  double range_sigma_m = 0.02;
  std::int64_t scan_period_ns = 100'000'000;
  // Now and then turns this far between two scans, to one side or the other, and later back: as
  // who carries a sensor looks about.
  double look_about_rad = 0.0;
  double traffic = 1.0;        // times the usual number of cars and people, 0.1 to 10
  double missing_share = 0.0;  // of returns, which fail to come by chance alone; below 1
  SensorProfile sensor;        // T_vehicle_lidar says where the sensor sits
};

// The same drive on foot: two scans a second, 0.7 m apart, and turns of 60 degrees between two.
DriveOptions carried_by_hand(DriveOptions options);

// The customary drives: 0 maps, 1 is 0.1 m to the left, 2 and later 0.3 m to the right; noise of
// 2.0, 2.25 and 2.5 cm.
DriveOptions usual_drive(const TownOptions& town, std::uint64_t drive, const SensorProfile& sensor);

struct TownScan {
  std::int64_t stamp_ns = 0;
  Pose T_town_vehicle = Pose::Identity();  // true; on the ground, not at the sensor
  std::vector<LabelledPoint> points;       // by azimuth, then by ring from below
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
};

// A whole drive in memory with its labels, for tests.
std::vector<TownScan> simulate(const DriveSimulator& drive, int threads);

// The same as passes take it, with the poses given: true or disturbed ones. The world is the
// town's coordinates.
Drive recorded(const DriveSimulator& drive, const std::string& name, std::span<const Pose> poses,
               int threads);

}  // namespace sightline::town
