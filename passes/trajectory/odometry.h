#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/geometry.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/local_match.h"

// The parts of estimate-trajectory that match scans. Poses here are the sensor's: T_map_lidar.

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
  // is too little to say, and where a piece begins.
  std::vector<std::optional<double>> overlap;
};

// Scan after scan against a map of the last `local_map_m` of the way, from where even motion since
// the scans before would take it, by their stamps. Where too little of a scan meets that map it is
// looked for at all headings and farther around; where that finds no place, or several alike, and
// where time jumps or a part of the drive begins, the scan begins a new piece with a map of its
// own, where the last scan was.
// `given`, one a scan, are T_map_lidar where a recording has them: they put the first scan in its
// place, and carry on where matching fails. Errors: drive-too-short, and what reading a scan says.
Result<Odometry> run_odometry(PassContext& ctx, double local_map_m, const Drive& drive,
                              const std::vector<std::optional<Pose>>& given);

// A pause after which a drive is not followed on: 1 s, and three times the usual step.
std::int64_t longest_step_ns(const Drive& drive);

}  // namespace sightline
