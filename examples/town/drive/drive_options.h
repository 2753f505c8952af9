#pragma once

#include <cstdint>

#include "formats/drive/sensor_profile.h"

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
  // The sensor turns while the car drives and its driver steers to and fro, so that each point has
  // a time of its own and the car turns unevenly within a scan.
  bool is_swept = false;
  double traffic = 1.0;        // times the usual number of cars and people, 0.1 to 10
  double missing_share = 0.0;  // of returns, which fail to come by chance alone; below 1
  // The speed changes by this share of the usual one, by a sine of 20 s; below 0.5.
  double speed_change = 0.0;
  bool has_fog = false;      // patches within 12 m that travel with the sensor
  double covered_deg = 0.0;  // of the view, around straight behind, where nothing is seen
  SensorProfile sensor;      // T_vehicle_lidar is the pose of the sensor
};

}  // namespace sightline::town
