#include <cmath>
#include <numbers>

#include "compiler/gate/rules/rules.h"

namespace sightline {
namespace {

std::vector<Found> unknown(std::string why) {
  return {{std::nullopt, std::nullopt, 0.0, std::move(why), false}};
}

std::vector<Found> find_plane_thickness(const GateInput& input, const Threshold&) {
  if (!input.map->sharpness) return unknown("the map does not say how sharp it is");
  const double thickness_m = std::sqrt(input.map->sharpness->of_map.mean_plane_variance_m2);
  return {{std::nullopt, std::nullopt, thickness_m,
           "planes of the map are " + told(thickness_m, "m") + " thick (standard deviation)"}};
}

std::vector<Found> find_less_sharp_than_given(const GateInput& input, const Threshold&) {
  const auto& sharpness = input.map->sharpness;
  if (!sharpness || !sharpness->of_given) {
    return unknown("the map does not say how sharp it was with poses given");
  }
  const double loss_nat =
      sharpness->of_map.mean_entropy_nat - sharpness->of_given->mean_entropy_nat;
  return {{std::nullopt, std::nullopt, loss_nat,
           "the mean entropy of the map is " + told(loss_nat, "nat") +
               " above that with the poses given"}};
}

std::vector<Found> find_residual(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->odometry_edges == 0) {
    return unknown("the map names no pose graph: its poses were given, or it is too old");
  }
  const double residual_m = trajectory->rms_translation_residual_m;
  return {{std::nullopt, std::nullopt, residual_m,
           "steps and loops of the trajectory disagree by " + told(residual_m, "m") + " (RMS)"}};
}

std::vector<Found> find_turn_residual(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->odometry_edges == 0) {
    return unknown("the map names no pose graph: its poses were given, or it is too old");
  }
  const double residual_deg = trajectory->rms_rotation_residual_rad * 180.0 / std::numbers::pi;
  return {
      {std::nullopt, std::nullopt, residual_deg,
       "steps and loops of the trajectory disagree by " + told(residual_deg, "deg") + " (RMS)"}};
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"trajectory-residual", kMap, kError, kAtMost, 0.10, "m",
     "Root mean square of what the pose graph left over, translation", find_residual},
    {"trajectory-turn-residual", kMap, kError, kAtMost, 0.5, "deg",
     "Root mean square of what the pose graph left over, rotation", find_turn_residual},
    {"plane-thickness", kMap, kWarning, kAtMost, 0.15, "m",
     "Sharpness: root of the mean plane variance of the scans laid on each other",
     find_plane_thickness},
    {"less-sharp-than-given", kMap, kWarning, kAtMost, 0.05, "nat",
     "Sharpness: mean map entropy with the poses used, less that with the poses given",
     find_less_sharp_than_given},
};

}  // namespace

std::span<const GateRule> rules_of_poses() { return kRules; }

}  // namespace sightline
