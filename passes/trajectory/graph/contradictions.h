#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/graph/pose_graph.h"

namespace sightline {

// A stretch of the later visit whose loops contradict the trajectory.
struct Contradiction {
  std::uint32_t first = 0;  // scans of the later visit
  std::uint32_t last = 0;
  std::uint32_t loop_count = 0;
  std::uint32_t off_count = 0;  // of these loops
  std::uint32_t earlier = 0;    // scans of the worst loop
  std::uint32_t later = 0;
  double off_m = 0.0;
};

// Contradictions by the loops (find_loops) between two pieces of the odometry, or within one, along
// the way of the later scans: where, of six consecutive loops, half and at least three put the
// later scan more than 0.25 m from `T_map_lidar`, five times the error of a loop. Right loops of
// recorded streets and of generated towns are within 0.1 m. A single false loop is outweighed by
// the others; where many contradict the trajectory, it is bent, or places that look alike were
// confused.
std::vector<Contradiction> find_contradictions(const Odometry& odometry,
                                               const std::vector<GraphEdge>& loops,
                                               const std::vector<Pose>& T_map_lidar);

// Poses of a drive, and the loops that contradict them.
struct Estimate {
  Trajectory trajectory;
  std::vector<Contradiction> contradictions = {};
};

std::string to_text(const Contradiction& found, const Drive& drive);

// "what: a; b; c; ...": the first five of the places that were found, by their to_text().
template <class Found>
std::string with_first_places(const std::string& what, const std::vector<Found>& found,
                              const Drive& drive) {
  constexpr std::size_t kMostTold = 5;
  std::string text = what;
  for (std::size_t i = 0; i < std::min(found.size(), kMostTold); ++i) {
    text += (i == 0 ? ": " : "; ") + to_text(found[i], drive);
  }
  if (found.size() > kMostTold) text += "; ...";
  return text;
}

// One warning of all contradictions; none without any.
void warn_of_contradictions(const PassContext& ctx, const Drive& drive,
                            const std::vector<Contradiction>& found);

}  // namespace sightline
