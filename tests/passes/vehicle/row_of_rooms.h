#pragma once

#include <string>
#include <vector>

#include "tests/passes/vehicle/localized_room.h"

// Rooms in a row along x, over many tiles, as a map to drive through.

namespace sightline {

inline constexpr int kRooms = 12;
inline constexpr double kRoomStep_m = 45.0;

inline Eigen::Vector3d room_place_m(int room) { return {kRoomStep_m * room, 7.0, 0.0}; }

inline const CompiledMap& map_of_rooms() {
  static const CompiledMap kMap = [] {
    CompiledMap map = random_map({.seed = 1, .ranges_m = {10.0, 20.0, 30.0}, .looks = {}});
    std::vector<Eigen::Vector3d> points_m;
    for (int room = 0; room < kRooms; ++room) {
      for (const Eigen::Vector3d& point_m :
           room_points(30U + static_cast<std::uint64_t>(room), 6000, 0.02)) {
        points_m.push_back(point_m + room_place_m(room));
      }
    }
    map.ndt = ndt_from_points(points_m, map.ndt.frame, {}, 1);
    return map;
  }();
  return kMap;
}

inline CompiledMap row_of_rooms(const std::string& localizer, std::uint32_t coarse_cells) {
  CompiledMap map = map_of_rooms();
  map.measurement.localizer.name = localizer;
  map.measurement.coarse_cells = coarse_cells;
  return map;
}

inline std::string written_row(const std::string& localizer, std::uint32_t coarse_cells = 1) {
  const std::filesystem::path path =
      scratch_folder() / ("row_" + localizer + std::to_string(coarse_cells) + ".slmap");
  EXPECT_TRUE(write_file_atomically(path, encode_map(row_of_rooms(localizer, coarse_cells)),
                                    IfExists::kReplace));
  return path.string();
}

// A match in a room by the C interface.
struct RowMatch {
  int code = 0;
  sightline_match match{};
};

// The look and the start of a room are always the same.
inline RowMatch match_in_room(const sightline_localizer* localizer, int room,
                              const MapFrame& frame) {
  Random random(100U + static_cast<std::uint64_t>(room));
  const Scan scan = float_scan(random.next(), 3000);
  const sightline_points points = points_of(scan);
  Pose T_map_start = random_start(random);
  T_map_start.translation() += room_place_m(room);
  const PoseRows start = world_rows(T_map_start, frame);
  const sightline_look look = c_look(kLooks[static_cast<std::size_t>(room) % std::size(kLooks)]);
  RowMatch result;
  result.code =
      sightline_localizer_match(localizer, &points, start.data(), &look, nullptr, &result.match);
  return result;
}

inline sightline_localizer_options whole_map() {
  sightline_localizer_options options{};
  options.holds_whole_map = 1;
  return options;
}

}  // namespace sightline
