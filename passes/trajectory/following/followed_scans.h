#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/geometry.h"

// What following a drive from scan to scan finds; part of estimate-trajectory.

namespace sightline {

// Why a piece begins at a scan.
struct PieceStart {
  std::uint32_t scan = 0;
  bool is_time_jump = false;  // else the scan was found nowhere near
  double overlap = 0.0;       // the best that was found with what was seen before; 0 where none was
  double overlap_elsewhere = 0.0;  // in another place than that one
};

struct Odometry {
  std::vector<Pose> T_map_lidar;  // one a scan
  std::vector<bool> is_matched;   // false: carried on from given poses or begins a piece
  std::vector<bool> is_far;       // found by a search: its step is known less well than others
  std::vector<double> driven_m;   // arc length up to each scan; a piece begins where the last ended
  // Scans of one piece are known relative to each other, ascending numbers from 0.
  std::vector<std::uint32_t> piece;
  std::vector<PieceStart> piece_starts;  // of every piece but the first
  // Share of the scan's upright returns that meet the local map (scan_overlap.h); none where there
  // is too little to say, where a piece begins, and where given poses lead to all scans.
  std::vector<std::optional<double>> overlap;
};

}  // namespace sightline
