#pragma once

#include <string>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"

namespace sightline {

// What the compiler knows of a LiDAR. Angles in degrees because people write these by hand.
struct SensorProfile {
  std::string name = "generic-16";
  std::vector<double> beam_elevations_deg;  // one per ring, ascending
  double azimuth_step_deg = 0.2;
  double azimuth_view_deg = 360.0;  // what it sees of a turn, half to each side of its +x axis
  double min_range_m = 1.0;
  double max_range_m = 100.0;
  double height_m = 1.8;                    // of the sensor's origin above ground
  Pose T_vehicle_lidar = Pose::Identity();  // identity where poses are the sensor's own

  [[nodiscard]] int ring_count() const { return static_cast<int>(beam_elevations_deg.size()); }
  [[nodiscard]] bool sees_all_round() const { return azimuth_view_deg >= 360.0; }
  [[nodiscard]] int azimuth_count() const;  // rays of one beam
  // Of the i-th ray of a beam, from the sensor's +x counter-clockwise. All round the first lies
  // along +x; else they lie evenly about it, the first to the right.
  [[nodiscard]] double azimuth_deg(int i) const;
};
SIGHTLINE_ARTIFACT(SensorProfile, "sensor-profile", 1)

// One of those built in: generic-16 to generic-128 are the examples' sensors, the others are of
// Velodyne, Ouster, Hesai and Livox. Error: unknown-name, which lists all.
Result<SensorProfile> sensor_profile(std::string_view name);
std::vector<std::string> sensor_profile_names();

Result<void> validate(const SensorProfile& profile);
Table dump(const SensorProfile& profile);
// One that sees all round has the bytes, and the table, that it had before any did not.
void encode(const SensorProfile& profile, ByteWriter& writer);
void decode(ByteReader& reader, SensorProfile& profile);

}  // namespace sightline
