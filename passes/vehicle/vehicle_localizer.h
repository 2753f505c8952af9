#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "formats/base/result.h"
#include "formats/reader/reader.h"
#include "passes/vehicle/sightline_localizer.h"

// Where a vehicle is: the C interface of libsightline-localizer for C++, in this header alone.
//
//   Result<MapReader> map = MapReader::open("town.slmap", "searching");
//   Result<VehicleLocalizer> localizer = VehicleLocalizer::open("town.slmap");  // or a .pcd
//   PoseRows T_world_vehicle = pose_rows({x_m, y_m, z_m}, {qx, qy, qz, qw});   // a first guess
//   for (std::vector<float> xyz_m; next_scan(xyz_m);) {
//     Result<LookAnswer> look = map->look(position_of(T_world_vehicle), 0.10);
//     Result<sightline_match> match =
//         localizer->match(points_of(std::span<const float>(xyz_m)), T_world_vehicle, look->look);
//     if (match) T_world_vehicle = pose_rows(*match);
//   }

namespace sightline {

// The upper three rows of a 4 x 4 matrix, row by row.
using PoseRows = std::array<double, 12>;

// Of a position and a quaternion, which need not be of length 1 but not of length 0.
inline PoseRows pose_rows(const std::array<double, 3>& position_m,
                          const std::array<double, 4>& quaternion_xyzw) {
  auto [x, y, z, w] = quaternion_xyzw;
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  x /= length, y /= length, z /= length, w /= length;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),     position_m[0],
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),     position_m[1],
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y), position_m[2]};
}

inline PoseRows pose_rows(const sightline_match& match) {
  PoseRows rows{};
  std::copy_n(match.T_world_vehicle, rows.size(), rows.begin());
  return rows;
}

inline std::array<double, 3> position_of(const PoseRows& pose) {
  return {pose[3], pose[7], pose[11]};
}

// Points of so many floats or doubles each, the first three of them x, y and z. Refers to them.
template <class Number>
sightline_points points_of(std::span<const Number> numbers, std::size_t numbers_a_point = 3) {
  static_assert(std::is_same_v<Number, float> || std::is_same_v<Number, double>);
  return {numbers.data(), numbers.size() / numbers_a_point, numbers_a_point * sizeof(Number),
          std::is_same_v<Number, double> ? 1 : 0};
}

// See sightline_localizer.h. Safe to use from several threads at once.
class VehicleLocalizer {
 public:
  // Opens a compiled map, a point cloud or a folder of clouds.
  static Result<VehicleLocalizer> open(const std::string& path,
                                       const sightline_localizer_options& options = {}) {
    sightline_localizer* opened = nullptr;
    std::array<char, 1024> message{};
    const int code =
        sightline_localizer_open(path.c_str(), &options, &opened, message.data(), message.size());
    if (code == 0) return VehicleLocalizer(opened);
    return Error{static_cast<ErrorCode>(code), message.data()};
  }

  // Of what a match answers `stop` says whether anything could be matched. `options`: what is known
  // of the start. Error: bad-argument, out-of-memory.
  [[nodiscard]] Result<sightline_match> match(const sightline_points& scan,
                                              const PoseRows& T_world_start, const MapLook& look,
                                              const sightline_match_options& options = {}) const {
    const sightline_look chosen = c_look(look);
    sightline_match answer;
    return checked(sightline_localizer_match(localizer_.get(), &scan, T_world_start.data(), &chosen,
                                             &options, &answer),
                   answer);
  }
  // Every return within a range.
  [[nodiscard]] Result<sightline_match> match(const sightline_points& scan,
                                              const PoseRows& T_world_start, double range_m,
                                              const sightline_match_options& options = {}) const {
    return match(scan, T_world_start, MapLook{.range_m = range_m}, options);
  }
  // By the map's plan, for a vehicle that tracks.
  [[nodiscard]] Result<sightline_match> match(const sightline_points& scan,
                                              const PoseRows& T_world_start,
                                              const LookPlanAnswer& plan,
                                              const sightline_match_options& options = {}) const {
    sightline_look_plan chosen{};
    chosen.first = c_look(plan.first.look);
    chosen.has_second = plan.has_second ? 1 : 0;
    std::copy(plan.weights.begin(), plan.weights.end(), chosen.weights);
    chosen.constant = plan.constant;
    chosen.doubt_above = plan.doubt_above;
    chosen.second = c_look(plan.second);
    sightline_match answer;
    return checked(sightline_localizer_match_plan(localizer_.get(), &scan, T_world_start.data(),
                                                  &chosen, &options, &answer),
                   answer);
  }

  // How well a scan fits the map at a pose, which stays: see sightline_localizer_score.
  [[nodiscard]] Result<sightline_match> score(const sightline_points& scan,
                                              const PoseRows& T_world_vehicle,
                                              const MapLook& look) const {
    const sightline_look chosen = c_look(look);
    sightline_match answer;
    return checked(sightline_localizer_score(localizer_.get(), &scan, T_world_vehicle.data(),
                                             &chosen, &answer),
                   answer);
  }

  // Prepares the map ahead of a vehicle at that place, for about so long; true once all is
  // prepared. Optional: see sightline_localizer_prepare. Error: bad-argument, out-of-memory.
  [[nodiscard]] Result<bool> prepare(const std::array<double, 3>& position_world_m,
                                     double budget_ms) const {
    int is_done = 0;
    const int code =
        sightline_localizer_prepare(localizer_.get(), position_world_m.data(), budget_ms, &is_done);
    if (code == 0) return is_done != 0;
    return Error{static_cast<ErrorCode>(code), "the position is not finite or far from the map"};
  }

  // Tiles of the map that could not be read so far.
  [[nodiscard]] std::vector<Error> faults() const {
    std::vector<Error> faults;
    for (std::size_t i = 0; i < sightline_localizer_fault_count(localizer_.get()); ++i) {
      std::array<char, 1024> message{};
      const int code =
          sightline_localizer_get_fault(localizer_.get(), i, message.data(), message.size());
      faults.push_back({static_cast<ErrorCode>(code), message.data()});
    }
    return faults;
  }

  [[nodiscard]] sightline_localizer_info info() const {
    sightline_localizer_info info;
    sightline_localizer_get_info(localizer_.get(), &info);
    return info;
  }

 private:
  explicit VehicleLocalizer(sightline_localizer* opened) : localizer_(opened) {}

  static sightline_look c_look(const MapLook& look) {
    sightline_look result{};
    result.range_m = look.range_m;
    result.return_count = look.return_count;
    result.even_beyond_m = look.even_beyond_m;
    result.point_count = look.point_count;
    result.is_by_normals = look.is_by_normals ? 1 : 0;
    result.settles = look.settles ? 1 : 0;
    return result;
  }

  static Result<sightline_match> checked(int code, const sightline_match& answer) {
    if (code == 0) return answer;
    return Error{static_cast<ErrorCode>(code),
                 "the start is not a rigid motion or far from the map, the look or an option is "
                 "invalid, or there are too many points"};
  }

  struct Close {
    void operator()(sightline_localizer* localizer) const { sightline_localizer_close(localizer); }
  };
  std::unique_ptr<sightline_localizer, Close> localizer_;
};

}  // namespace sightline
