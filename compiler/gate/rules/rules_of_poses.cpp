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
           "planes of the map are " + in_words(thickness_m, "m") + " thick (standard deviation)"}};
}

std::vector<Found> find_less_sharp_than_given(const GateInput& input, const Threshold&) {
  const auto& sharpness = input.map->sharpness;
  if (!sharpness || !sharpness->of_given) {
    return unknown("the map does not say how sharp it was with poses given");
  }
  const double loss_nat =
      sharpness->of_map.mean_entropy_nat - sharpness->of_given->mean_entropy_nat;
  return {{std::nullopt, std::nullopt, loss_nat,
           "the mean entropy of the map is " + in_words(loss_nat, "nat") +
               " above that with the poses given"}};
}

// A building that is laid twice has an entropy like one that is laid once; its walls are thicker.
std::vector<Found> find_thicker_than_given(const GateInput& input, const Threshold&) {
  const auto& sharpness = input.map->sharpness;
  if (!sharpness || !sharpness->of_given) {
    return unknown("the map does not say how sharp it was with poses given");
  }
  const double thicker_m = std::sqrt(sharpness->of_map.mean_plane_variance_m2) -
                           std::sqrt(sharpness->of_given->mean_plane_variance_m2);
  return {{std::nullopt, std::nullopt, thicker_m,
           "planes of the map are " + in_words(thicker_m, "m") +
               " thicker than with the poses given (standard deviation)"}};
}

std::vector<Found> find_residual(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->odometry_edges == 0) {
    return unknown("the map names no pose graph: its poses were given, or it is too old");
  }
  const double residual_m = trajectory->rms_translation_residual_m;
  return {
      {std::nullopt, std::nullopt, residual_m,
       "steps and loops of the trajectory disagree by " + in_words(residual_m, "m") + " (RMS)"}};
}

std::vector<Found> find_turn_residual(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->odometry_edges == 0) {
    return unknown("the map names no pose graph: its poses were given, or it is too old");
  }
  const double residual_deg = trajectory->rms_rotation_residual_rad * 180.0 / std::numbers::pi;
  return {{std::nullopt, std::nullopt, residual_deg,
           "steps and loops of the trajectory disagree by " + in_words(residual_deg, "deg") +
               " (RMS)"}};
}

std::vector<Found> find_pieces(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->pieces.empty()) {
    return unknown("the map does not say of how many pieces its trajectory is");
  }
  const std::size_t count = trajectory->pieces.size();
  std::string text = "the trajectory is of " + std::to_string(count) +
                     " pieces; how they lie to each other is not known";
  if (count == 1) text = "the trajectory is of one piece";
  for (std::size_t i = 1; i < count; ++i) {
    text += (i == 1 ? "; one begins at scan " : ", at scan ") +
            std::to_string(trajectory->pieces[i].first_scan);
  }
  return {{std::nullopt, std::nullopt, static_cast<double>(count), text}};
}

std::vector<Found> find_overlap(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->overlap_count == 0) {
    return unknown("the map does not say how its scans overlap: its poses were given");
  }
  return {{std::nullopt, std::nullopt, trajectory->median_overlap,
           "of what half of the scans see upright, less than " +
               in_words(trajectory->median_overlap, "share") + " meets what was seen before them"}};
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"trajectory-residual", kMap, kError, kAtMost, 0.10, "m",
     "Root mean square of what the pose graph left over, translation", find_residual},
    {"trajectory-turn-residual", kMap, kError, kAtMost, 0.5, "deg",
     "Root mean square of what the pose graph left over, rotation", find_turn_residual},
    {"trajectory-pieces", kMap, kError, kAtMost, 1.0, "pieces",
     "Pieces of the trajectory: how they lie to each other is not known, and the scans that begin "
     "them are named",
     find_pieces},
    {"scan-overlap", kMap, kWarning, kAtLeast, 0.5, "share",
     "Median share of a scan's upright returns that meet what was seen before it", find_overlap},
    {"plane-thickness", kMap, kWarning, kAtMost, 0.15, "m",
     "Sharpness: root of the mean plane variance of the scans laid on each other",
     find_plane_thickness},
    {"thicker-than-given", kMap, kWarning, kAtMost, 0.01, "m",
     "Sharpness: root of the mean plane variance with the poses used, less that with the poses "
     "given",
     find_thicker_than_given},
    {"less-sharp-than-given", kMap, kWarning, kAtMost, 0.05, "nat",
     "Sharpness: mean map entropy with the poses used, less that with the poses given",
     find_less_sharp_than_given},
};

}  // namespace

std::span<const GateRule> rules_of_poses() { return kRules; }

}  // namespace sightline
