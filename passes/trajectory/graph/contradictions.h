#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"

// Whether a trajectory is what its loops say; part of estimate-trajectory.

namespace sightline {

// A stretch of the later visit, loops of which put it elsewhere than the trajectory does.
struct Contradiction {
  std::uint32_t first = 0;  // scans of the later visit
  std::uint32_t last = 0;
  std::uint32_t loop_count = 0;
  std::uint32_t off_count = 0;  // of these loops
  std::uint32_t earlier = 0;    // scans of the loop that is farthest off
  std::uint32_t later = 0;
  double off_m = 0.0;
};

// Of loops (find_loops) between two pieces of the odometry, or within one, along the way of the
// later scans: where of six that follow each other half and at least three say that the later scan
// lies more than 0.25 m, five times what a loop is off, from where `T_map_lidar` has it. Loops of
// recorded streets and of generated towns are met within 0.1 m. A false one stands alone, and the
// others outweigh it. Where many are not met the trajectory is bent, or places that look alike were
// taken for each other.
std::vector<Contradiction> find_contradictions(const Odometry& odometry,
                                               const std::vector<GraphEdge>& loops,
                                               const std::vector<Pose>& T_map_lidar);

std::string to_text(const Contradiction& found, const Drive& drive);
// One warning of all of them; none where there are none.
void warn_of_contradictions(const PassContext& ctx, const Drive& drive,
                            const std::vector<Contradiction>& found);

}  // namespace sightline
