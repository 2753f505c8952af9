#include "formats/drive/sensor_profile.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

// Elevations from `first_deg` to `last_deg`, both included, evenly.
std::vector<double> even_beams(int count, double first_deg, double last_deg) {
  std::vector<double> beams;
  for (int i = 0; i < count; ++i) {
    beams.push_back(first_deg + (last_deg - first_deg) * i / (count - 1));
  }
  return beams;
}

SensorProfile generic(int rings) {
  SensorProfile profile;
  profile.name = "generic-" + std::to_string(rings);
  profile.beam_elevations_deg = even_beams(rings, -15.0, 15.0);
  return profile;
}

// Velodyne VLP-16 manual: 16 beams 2 degrees apart; 0.2 degrees of azimuth at 10 Hz.
SensorProfile vlp_16() {
  SensorProfile profile = generic(16);
  profile.name = "vlp-16";
  return profile;
}

// Velodyne HDL-32E manual: 32 beams 4/3 degrees apart, +10.67 to -30.67.
SensorProfile hdl_32e() {
  SensorProfile profile;
  profile.name = "hdl-32e";
  profile.beam_elevations_deg = even_beams(32, -30.67, 10.67);
  profile.azimuth_step_deg = 0.16;
  profile.max_range_m = 100.0;
  return profile;
}

// Velodyne HDL-64E S2 manual: the lower bank of 32 beams 1/2 degree apart from -24.33 to -8.83, the
// upper 1/3 degree apart from -8.33 to +2. Height above ground as KITTI mounts it.
SensorProfile hdl_64e() {
  SensorProfile profile;
  profile.name = "hdl-64e";
  profile.beam_elevations_deg = even_beams(32, -24.33, -8.83);
  const std::vector<double> upper = even_beams(32, -8.33, 2.0);
  profile.beam_elevations_deg.insert(profile.beam_elevations_deg.end(), upper.begin(), upper.end());
  profile.azimuth_step_deg = 0.1728;
  profile.max_range_m = 120.0;
  profile.height_m = 1.73;
  return profile;
}

// Ouster OS1-64 (first generation): 64 beams over 33.2 degrees; 1024 columns a turn.
SensorProfile os1_64() {
  SensorProfile profile;
  profile.name = "os1-64";
  profile.beam_elevations_deg = even_beams(64, -16.6, 16.6);
  profile.azimuth_step_deg = 360.0 / 1024.0;
  profile.max_range_m = 120.0;
  return profile;
}

std::vector<SensorProfile> built_in_profiles() {
  return {generic(16), generic(32), generic(64), generic(128),
          vlp_16(),    hdl_32e(),   hdl_64e(),   os1_64()};
}

Error invalid(const SensorProfile& profile, const std::string& what) {
  return {ErrorCode::kInvalidArtifact, what, "", "sensor profile " + profile.name};
}

bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

std::vector<std::string> sensor_profile_names() {
  std::vector<std::string> names;
  for (const SensorProfile& profile : built_in_profiles()) names.push_back(profile.name);
  return names;
}

Result<SensorProfile> sensor_profile(std::string_view name) {
  std::string known;
  for (SensorProfile& profile : built_in_profiles()) {
    if (profile.name == name) return std::move(profile);
    known += " " + profile.name;
  }
  return Error{ErrorCode::kUnknownName,
               "unknown sensor profile '" + std::string(name) + "', expected one of" + known, "",
               ""};
}

Result<void> validate(const SensorProfile& profile) {
  const std::vector<double>& beams = profile.beam_elevations_deg;
  if (beams.empty()) return invalid(profile, "no beams");
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (!(std::abs(beams[i]) <= 90.0)) {
      return invalid(profile, "a beam's elevation is not within -90 to 90 degrees");
    }
    if (i > 0 && !(beams[i] > beams[i - 1])) return invalid(profile, "beams do not ascend");
  }
  if (!is_positive(profile.azimuth_step_deg) || profile.azimuth_step_deg > 360.0) {
    return invalid(profile, "the azimuth step is not within 0 to 360 degrees");
  }
  if (!(profile.min_range_m >= 0.0) || !is_positive(profile.max_range_m) ||
      profile.max_range_m <= profile.min_range_m) {
    return invalid(profile, "the range is empty");
  }
  if (!std::isfinite(profile.height_m)) return invalid(profile, "the height is not finite");
  if (!is_rigid(profile.T_vehicle_lidar)) {
    return invalid(profile, "T_vehicle_lidar is no rotation and translation");
  }
  return {};
}

Table dump(const SensorProfile& profile) {
  Table table;
  table.name = "sensor-profile";
  table.facts = {{"profile", profile.name},
                 {"azimuth_step_deg", profile.azimuth_step_deg},
                 {"min_range_m", profile.min_range_m},
                 {"max_range_m", profile.max_range_m},
                 {"height_m", profile.height_m}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      table.facts.emplace_back("T_vehicle_lidar_" + std::to_string(row) + std::to_string(column),
                               profile.T_vehicle_lidar(row, column));
    }
  }
  table.columns = {"ring", "elevation_deg"};
  for (std::size_t i = 0; i < profile.beam_elevations_deg.size(); ++i) {
    table.rows.push_back({static_cast<std::int64_t>(i), profile.beam_elevations_deg[i]});
  }
  return table;
}

void encode(const SensorProfile& profile, ByteWriter& writer) {
  writer.put_string(profile.name);
  writer.put_array(profile.beam_elevations_deg);
  writer.put(profile.azimuth_step_deg);
  writer.put(profile.min_range_m);
  writer.put(profile.max_range_m);
  writer.put(profile.height_m);
  encode(profile.T_vehicle_lidar, writer);
}

void decode(ByteReader& reader, SensorProfile& profile) {
  reader.get_string(profile.name);
  reader.get_array(profile.beam_elevations_deg);
  reader.get(profile.azimuth_step_deg);
  reader.get(profile.min_range_m);
  reader.get(profile.max_range_m);
  reader.get(profile.height_m);
  decode(reader, profile.T_vehicle_lidar);
}

}  // namespace sightline
