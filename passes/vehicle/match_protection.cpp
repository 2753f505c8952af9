#include "passes/vehicle/match_protection.h"

#include <cmath>

namespace sightline {
namespace {

constexpr double kUsualRisk = 0.01;

bool is_number_of_place(double number) { return number >= 0.0 && std::isfinite(number); }

}  // namespace

std::optional<MatchKnowledge> knowledge_of(const GivenErrors& given, PlaceKind kind) {
  const auto& [covariance, variance_factor, map_m, map_rad, risk] = given;
  if (!is_number_of_place(variance_factor) || !is_number_of_place(map_m) ||
      !is_number_of_place(map_rad) || !(risk >= 0.0 && risk < 1.0)) {
    return std::nullopt;
  }
  MatchKnowledge knowledge;
  knowledge.kind = kind;
  knowledge.scale.covariance_factor = protection_row(kind).covariance_factor;
  if (covariance != nullptr) {
    const Eigen::Map<const Matrix6d> start(covariance);
    if (!is_covariance(start)) return std::nullopt;
    knowledge.start_covariance = 0.5 * (start + start.transpose());
    knowledge.protection_risk = risk > 0.0 ? risk : kUsualRisk;
  }
  if (variance_factor > 0.0) knowledge.scale.variance_factor = variance_factor;
  if (map_m > 0.0 || map_rad > 0.0) {
    knowledge.scale.map_m = map_m;
    knowledge.scale.map_rad = map_rad;
  }
  if (variance_factor > 0.0 || map_m > 0.0 || map_rad > 0.0) {
    knowledge.scale.covariance_factor = 1.0;
    knowledge.protection_risk = 0.0;
  }
  return knowledge;
}

const ProtectionRow& protection_row(PlaceKind kind) {
  return protection_row(group_of_kind(static_cast<unsigned>(kind)));
}

ProtectionFactors levels_of_match(const MatchKnowledge& knowledge, const PoseEstimate& estimate) {
  if (knowledge.protection_risk > 0.0) {
    return protection_levels(estimate, protection_row(knowledge.kind), knowledge.protection_risk);
  }
  return {kUnavailable, kUnavailable, kUnavailable, kUnavailable};
}

}  // namespace sightline
