#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "passes/map/seen_voxels.h"

namespace sightline {

// Evidence for standing, by OctoMap's sensor model: log odds of hits and misses. Below 0: it moved.
double log_odds(const SeenVoxel& voxel);
double log_odds(std::uint32_t hits, std::uint32_t misses);

// What stands beyond doubt has as much: OctoMap's clamping threshold, P(occupied) = 0.97.
inline constexpr double kStrongLogOdds = 3.5;

// Whether a voxel stands beyond doubt even if every one of `scan_count` scans that did not hit it
// looks through it: no ray need be asked.
bool stands_anyway(const SeenVoxel& voxel, std::size_t scan_count);

// Farthest that one voxel's verdict depends on others, m.
double reach_of_judgement_m(double voxel_m);

// One a voxel: 1 where it moved. After mark_ground.
std::vector<std::uint8_t> judge(const SeenVoxels& seen);

}  // namespace sightline
