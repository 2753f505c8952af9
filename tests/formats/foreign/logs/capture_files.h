#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/foreign/foreign_files.h"

// Captures that write_captures.py made of beams in a box with six different walls.

namespace sightline {

inline constexpr std::int64_t kCaptureStart_ns = 1'700'000'000'000'000'000;

inline std::filesystem::path capture_file(const std::string& name) {
  return std::filesystem::path(SIGHTLINE_CAPTURES) / name;
}

inline double to_wall_m(const Eigen::Vector3d& p_m) {
  constexpr std::array<std::array<double, 2>, 3> kBox_m = {
      {{-7.0, 11.0}, {-5.0, 8.5}, {-2.0, 6.0}}};
  double least_m = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double wall_m : kBox_m.at(static_cast<std::size_t>(axis))) {
      least_m = std::min(least_m, std::abs(p_m[axis] - wall_m));
    }
  }
  return least_m;
}

inline double azimuth_deg(const Eigen::Vector3d& p_m) {
  return std::atan2(p_m.y(), p_m.x()) * 180.0 / M_PI;
}

inline Result<Recording> open_capture_file(const std::filesystem::path& file,
                                           const std::string& sensor = "generic-16") {
  RecordingOptions options;
  options.scans = file.string();
  options.sensor = sensor;
  return open_recording(options);
}

inline std::string outcome_of(const std::filesystem::path& file,
                              const std::string& sensor = "generic-16") {
  return outcome_of(open_capture_file(file, sensor));
}

// Changes one byte after the other, `step` apart, and cuts there: an error that names the file, or
// scans that can be read.
inline void expect_damage_is_survived(const std::string& bytes, const std::string& companion,
                                      const std::string& ending, std::size_t step) {
  const ScratchFolder folder;
  folder.write("drive" + ending, companion);
  const auto look = [&](const std::string& damaged) {
    const Result<Recording> recording = open_capture_file(folder.write("drive.pcap", damaged));
    if (!recording) {
      EXPECT_FALSE(recording.error().file.empty()) << to_string(recording.error());
      return;
    }
    for (std::size_t i = 0; i < recording->scans.size(); ++i) {
      const Result<PointCloudFile> cloud = read_recorded_scan(*recording, i);
      if (!cloud) continue;
      EXPECT_EQ(cloud->points_m.size(), cloud->time_offset_ns.size());
    }
  };
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    look(bytes.substr(0, at));
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at / step % 8)));
    look(flipped);
  }
}

}  // namespace sightline
