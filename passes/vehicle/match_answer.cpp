#include "passes/vehicle/match_answer.h"

#include <algorithm>
#include <cstdint>

#include "passes/vehicle/c_values.h"

namespace sightline {
namespace {

void put_levels(const ProtectionFactors& levels, sightline_match& answer) {
  std::copy_n(levels.begin(), 3, answer.protection_m);
  answer.protection_yaw_rad = levels[3];
}

}  // namespace

void put_start(const double T_world_start[12], sightline_match& answer) {
  answer = {};
  put_levels({kUnavailable, kUnavailable, kUnavailable, kUnavailable}, answer);
  if (T_world_start != nullptr) std::copy_n(T_world_start, 12, answer.T_world_vehicle);
  answer.stop = SIGHTLINE_NO_POINTS;
}

void put(const MatchResult& found, sightline_match& answer) {
  answer.score = found.score;
  answer.nearest_voxel_likelihood = found.nearest_voxel_likelihood;
  answer.work = found.work;
  answer.iterations = found.iterations;
  answer.stop = static_cast<std::uint32_t>(found.stop);
  answer.scored_points = found.scored_points;
}

void put(const MatchEnd& end, const MapFrame& frame, sightline_match& answer) {
  put_pose(rebase(end.estimate.T_map_vehicle, frame, MapFrame{}), answer.T_world_vehicle);
  put_matrix(end.information, answer.information);
  put_matrix(end.estimate.covariance, answer.covariance);
  answer.weak = end.weak;
}

void put(const RaisedPoints& raised, sightline_match& answer) {
  answer.raised_points = raised.count;
  answer.raised_met = raised.met_count;
}

void put_protection(const MatchKnowledge& knowledge, const MatchResult& found, const MatchEnd& end,
                    sightline_match& answer) {
  const ProtectionRow& row = protection_row(knowledge.kind);
  answer.place_kind = static_cast<std::uint32_t>(knowledge.kind);
  answer.protection_blocks = row.block_count;
  answer.integrity = static_cast<std::uint32_t>(integrity_of(found, answer.point_count, row));
  if (answer.stop > SIGHTLINE_ITERATION_LIMIT) return;
  put_levels(levels_of_match(knowledge, end.estimate), answer);
}

}  // namespace sightline
