#include "passes/vehicle/match_protection.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

static_assert(SIGHTLINE_INTEGRITY_UNKNOWN == static_cast<unsigned>(Integrity::kUnknown));
static_assert(SIGHTLINE_INTEGRITY_OK == static_cast<unsigned>(Integrity::kOk));
static_assert(SIGHTLINE_INTEGRITY_DOUBTFUL == static_cast<unsigned>(Integrity::kDoubtful));
static_assert(SIGHTLINE_INTEGRITY_LOST == static_cast<unsigned>(Integrity::kLost));

constexpr double kUsualRisk = 0.01;

const ProtectionRow& row_of(PlaceKind kind) {
  return protection_row(group_of_kind(static_cast<unsigned>(kind)));
}

bool is_number_of_place(double number) { return number >= 0.0 && std::isfinite(number); }

}  // namespace

std::optional<MatchKnowledge> knowledge_of(const sightline_match_options* options, PlaceKind kind) {
  MatchKnowledge knowledge;
  knowledge.kind = kind;
  knowledge.scale.covariance_factor = row_of(kind).covariance_factor;
  if (options == nullptr) return knowledge;
  const auto& [covariance, variance_factor, map_m, map_rad, risk] = *options;
  if (!is_number_of_place(variance_factor) || !is_number_of_place(map_m) ||
      !is_number_of_place(map_rad) || !(risk >= 0.0 && risk < 1.0)) {
    return std::nullopt;
  }
  if (covariance != nullptr) {
    const Eigen::Map<const Matrix6d> given(covariance);
    if (!is_covariance(given)) return std::nullopt;
    knowledge.start_covariance = 0.5 * (given + given.transpose());
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

void put_protection(const MatchKnowledge& knowledge, const MatchResult& found, const MatchEnd& end,
                    sightline_match& answer) {
  const ProtectionRow& row = row_of(knowledge.kind);
  answer.place_kind = static_cast<std::uint32_t>(knowledge.kind);
  answer.protection_blocks = row.block_count;
  answer.integrity = static_cast<std::uint32_t>(integrity_of(found, answer.point_count, row));
  const bool is_matched =
      answer.stop == SIGHTLINE_CONVERGED || answer.stop == SIGHTLINE_ITERATION_LIMIT;
  if (!is_matched || knowledge.protection_risk <= 0.0) return;
  const ProtectionFactors levels =
      protection_levels(end.estimate, row, knowledge.protection_risk);
  std::copy_n(levels.begin(), 3, answer.protection_m);
  answer.protection_yaw_rad = levels[3];
}

void put_unavailable(sightline_match& answer) {
  std::fill_n(answer.protection_m, 3, kUnavailable);
  answer.protection_yaw_rad = kUnavailable;
}

}  // namespace sightline
