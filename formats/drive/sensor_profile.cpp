#include "formats/drive/sensor_profile.h"

#include <cmath>

namespace sightline {
namespace {

Error invalid_profile(const SensorProfile& profile, const std::string& what) {
  return {ErrorCode::kInvalidArtifact, what, "", "sensor profile " + profile.name};
}

bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

int SensorProfile::azimuth_count() const {
  return static_cast<int>(std::lround(azimuth_view_deg / azimuth_step_deg));
}

double SensorProfile::azimuth_deg(int i) const {
  const double first_deg = sees_all_round() ? 0.0 : -0.5 * (azimuth_count() - 1) * azimuth_step_deg;
  return first_deg + i * azimuth_step_deg;
}

Result<void> validate(const SensorProfile& profile) {
  const std::vector<double>& beams = profile.beam_elevations_deg;
  if (beams.empty()) return invalid_profile(profile, "no beams");
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (!(std::abs(beams[i]) <= 90.0)) {
      return invalid_profile(profile, "a beam's elevation is not within -90 to 90 degrees");
    }
    if (i > 0 && !(beams[i] > beams[i - 1]))
      return invalid_profile(profile, "the beams' elevations must ascend");
  }
  if (!is_positive(profile.azimuth_step_deg) || profile.azimuth_step_deg > 360.0) {
    return invalid_profile(profile, "the azimuth step is not within 0 to 360 degrees");
  }
  if (!(profile.azimuth_view_deg >= profile.azimuth_step_deg &&
        profile.azimuth_view_deg <= 360.0)) {
    return invalid_profile(profile,
                           "the azimuth view is not within one azimuth step to 360 degrees");
  }
  if (!(profile.min_range_m >= 0.0) || !is_positive(profile.max_range_m) ||
      profile.max_range_m <= profile.min_range_m) {
    return invalid_profile(profile, "the range is empty");
  }
  if (!std::isfinite(profile.height_m)) return invalid_profile(profile, "the height is not finite");
  if (!is_rigid(profile.T_vehicle_lidar)) {
    return invalid_profile(profile, "T_vehicle_lidar is not a rotation and translation");
  }
  return {};
}

Table dump(const SensorProfile& profile) {
  Table table{"sensor-profile", {}, {}, {}};
  table.facts = {{"profile", profile.name},
                 {"azimuth_step_deg", profile.azimuth_step_deg},
                 {"min_range_m", profile.min_range_m},
                 {"max_range_m", profile.max_range_m},
                 {"height_m", profile.height_m}};
  if (!profile.sees_all_round()) {
    table.facts.emplace_back("azimuth_view_deg", profile.azimuth_view_deg);
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      table.facts.emplace_back(concat("T_vehicle_lidar_", row, column),
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
  // A step below zero says that the view follows.
  writer.put(profile.sees_all_round() ? profile.azimuth_step_deg : -profile.azimuth_step_deg);
  if (!profile.sees_all_round()) writer.put(profile.azimuth_view_deg);
  writer.put(profile.min_range_m);
  writer.put(profile.max_range_m);
  writer.put(profile.height_m);
  encode(profile.T_vehicle_lidar, writer);
}

void decode(ByteReader& reader, SensorProfile& profile) {
  reader.get_string(profile.name);
  reader.get_array(profile.beam_elevations_deg);
  reader.get(profile.azimuth_step_deg);
  profile.azimuth_view_deg = 360.0;
  if (profile.azimuth_step_deg < 0.0) {
    profile.azimuth_step_deg = -profile.azimuth_step_deg;
    reader.get(profile.azimuth_view_deg);
  }
  reader.get(profile.min_range_m);
  reader.get(profile.max_range_m);
  reader.get(profile.height_m);
  decode(reader, profile.T_vehicle_lidar);
}

}  // namespace sightline
