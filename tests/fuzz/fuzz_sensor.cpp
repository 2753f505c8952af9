// Poses in degrees and in tables, beams and calibrations. The first byte decides which; the rest is
// the file.

#include <array>

#include "formats/foreign/text/dataset_poses.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/sensor_file.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

void check(const Error& error) {
  check_refusal(error, {ErrorCode::kTooLarge}, /*may_be_usage=*/true);
}

void check_track(const FileBytes& file) {
  const bool is_nmea = file.text().starts_with('$');
  const Result<GeodeticTrack> track = is_nmea ? parse_nmea(file) : parse_gnss_csv(file);
  if (!track) return check(track.error());
  for (const char* world : {"local", "utm:32N"}) {
    const Result<TrackInWorld> found = in_world(*track, world, file.file);
    if (!found) {
      check(found.error());
      continue;
    }
    SIGHTLINE_CHECK(found->rows.size() == track->fixes.size());
    for (const PoseRow& row : found->rows) SIGHTLINE_CHECK(is_rigid(row.T_world_vehicle));
  }
}

void check_sensor(std::string_view text, const char* name) {
  const Result<SensorProfile> profile = parse_sensor_file(text, name);
  if (!profile) return check(profile.error());
  SIGHTLINE_CHECK(validate(*profile).has_value());
}

void check_calibration(std::string_view text, const char* name) {
  const Result<KittiCalibration> calibration = parse_kitti_calibration(text, name);
  if (!calibration) return check(calibration.error());
  SIGHTLINE_CHECK(is_rigid(lidar_pose(*calibration, Pose::Identity())));
}

void check_table(std::string_view text, const char* name) {
  const Result<std::vector<PoseRow>> rows = parse_nuscenes_poses(text, name);
  if (!rows) return check(rows.error());
  for (std::size_t i = 0; i < rows->size(); ++i) {
    SIGHTLINE_CHECK(is_rigid((*rows)[i].T_world_vehicle));
    SIGHTLINE_CHECK(i == 0 || *(*rows)[i - 1].stamp_ns < *(*rows)[i].stamp_ns);
  }
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  constexpr std::array<const char*, 6> kNames = {"a.csv",  "a.yaml",    "a.csv",
                                                 "a.json", "calib.txt", "ego_pose.json"};
  const std::size_t kind = data[0] % kNames.size();
  const FuzzInput input(data + 1, size - 1);
  const FileBytes file{input.bytes(), kNames[kind]};
  if (kind == 0) {
    check_track(file);
  } else if (kind < 4) {
    check_sensor(file.text(), kNames[kind]);
  } else if (kind == 4) {
    check_calibration(file.text(), kNames[kind]);
  } else {
    check_table(file.text(), kNames[kind]);
  }
  return 0;
}
