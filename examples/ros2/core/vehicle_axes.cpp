#include "vehicle_axes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sightline_ros2 {
namespace {

// Variance of the position along a unit vector: column `axis` of the pose.
double variance_along(const PoseRows& T_map_base, std::size_t axis, const Covariance& covariance) {
  double variance = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      variance += T_map_base[4 * i + axis] * covariance[6 * i + j] * T_map_base[4 * j + axis];
    }
  }
  return std::max(0.0, variance);
}

}  // namespace

VehicleSigmas sigmas_of(const Pose& T_map_base, const Covariance& covariance) {
  const PoseRows rows = rows_of(T_map_base);
  return {std::sqrt(variance_along(rows, 0, covariance)),
          std::sqrt(variance_along(rows, 1, covariance)), std::sqrt(std::max(0.0, covariance[35]))};
}

Covariance in_map_axes(const Pose& T_map_base, const Covariance& of_vehicle) {
  const PoseRows rows = rows_of(T_map_base);
  Covariance covariance = of_vehicle;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t l = 0; l < 3; ++l) {
          sum += rows[4 * i + k] * of_vehicle[6 * k + l] * rows[4 * j + l];
        }
      }
      covariance[6 * i + j] = sum;
    }
  }
  return covariance;
}

std::string names_of_weak(std::uint32_t weak) {
  const std::pair<std::uint32_t, const char*> names[] = {
      {SIGHTLINE_WEAK_FORWARD, "forward"}, {SIGHTLINE_WEAK_LEFT, "left"},
      {SIGHTLINE_WEAK_UP, "up"},           {SIGHTLINE_WEAK_ROLL, "roll"},
      {SIGHTLINE_WEAK_PITCH, "pitch"},     {SIGHTLINE_WEAK_YAW, "yaw"}};
  std::string text;
  for (const auto& [bit, name] : names) {
    if ((weak & bit) != 0) text += (text.empty() ? "" : ", ") + std::string(name);
  }
  return text.empty() ? "none" : text;
}

}  // namespace sightline_ros2
