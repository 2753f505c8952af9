#pragma once

#include <gtest/gtest.h>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "passes/map/build_ndt.h"
#include "passes/vehicle/sightline_localizer.h"
#include "tests/formats/map/random_map.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/scratch_folder.h"

// A room to localize in, by the C interface.

namespace sightline {

using PoseRows = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;

inline const Look kLooks[] = {
    every_return(8.0),
    every_return(30.0),
    {.range_m = 20.0, .return_count = 900},
    {.range_m = 20.0, .return_count = 2000, .even_beyond_m = 6.0, .point_count = 120},
    {.range_m = 25.0, .return_count = 2000, .point_count = 80, .is_by_normals = true},
    {.range_m = 25.0, .return_count = 1000, .point_count = 90, .mode = LookMode::kSettle}};

inline sightline_look c_look(const Look& look) {
  sightline_look result{};
  result.range_m = look.range_m;
  result.return_count = look.return_count;
  result.even_beyond_m = look.even_beyond_m;
  result.point_count = look.point_count;
  result.is_by_normals = look.is_by_normals ? 1 : 0;
  result.settles = look.mode == LookMode::kSettle ? 1 : 0;
  return result;
}

// Of points that a float holds, so that both kinds of numbers say the same.
inline Scan float_scan(std::uint64_t seed, std::size_t count) {
  Scan scan;
  scan.points_m = room_points(seed, count, 0.02);
  for (Eigen::Vector3d& point_m : scan.points_m) point_m = point_m.cast<float>().cast<double>();
  return scan;
}

inline sightline_points points_of(const Scan& scan) {
  return {scan.points_m.data(), scan.points_m.size(), sizeof(Eigen::Vector3d), 1};
}

// The room as a map whose errors were measured with that localizer.
inline std::string written_room(const std::string& localizer) {
  CompiledMap map = random_map({.seed = 1});
  map.ndt = ndt_from_points(room_points(21, 30000, 0.02), map.ndt.frame, {}, 1);
  map.measurement.localizer.name = localizer;
  const std::filesystem::path path = scratch_folder() / ("room_" + localizer + ".slmap");
  EXPECT_TRUE(write_file_atomically(path, encode_map(map), IfExists::kReplace));
  return path.string();
}

struct Opened {
  explicit Opened(const std::string& path, const sightline_localizer_options* options = nullptr) {
    std::array<char, 500> text{};
    code = sightline_localizer_open(path.c_str(), options, &localizer, text.data(), text.size());
    message = text.data();
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  ~Opened() { sightline_localizer_close(localizer); }
  [[nodiscard]] sightline_localizer_info info() const {
    sightline_localizer_info result;
    sightline_localizer_get_info(localizer, &result);
    return result;
  }

  sightline_localizer* localizer = nullptr;
  int code = 0;
  std::string message;
};

inline Pose random_start(Random& random) {
  Pose pose = Pose::Identity();
  pose.translation() = random_vector(random, -0.7, 0.7);
  pose.linear() =
      Eigen::AngleAxisd(random.uniform(-0.03, 0.03), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return pose;
}

inline PoseRows world_rows(const Pose& T_map, const MapFrame& frame) {
  return rebase(T_map, frame, MapFrame{}).affine();
}

inline std::string_view bytes_of(const sightline_match& match) {
  return {reinterpret_cast<const char*>(&match), sizeof match};
}

}  // namespace sightline
