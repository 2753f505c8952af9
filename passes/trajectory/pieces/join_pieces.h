#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/pose_graph_types.h"

// What becomes of the pieces of an odometry; part of estimate-trajectory.

namespace sightline {

struct JoinedPieces {
  std::vector<std::uint32_t> piece;  // of each scan, after joining; ascending from 0
  std::vector<PieceStart> starts;    // of every piece that is left, but the first
  std::vector<GraphEdge> edges;      // that join odometry's pieces, between scans
  std::vector<std::uint32_t> held;   // the first scan of each piece that is left, but the first
};

// What is known of the pieces beforehand.
struct KnownPieces {
  // Of each a number; those of one number lie right to each other. Empty: nothing is known.
  std::vector<std::uint32_t> number;
  std::uint32_t fixed = 0;  // so many of the first pieces are not moved
};

// Joins pieces that saw the same place: several scans of the later one, each looked for in maps of
// the earlier one at all headings, agree on where it lies, and scans all along it fit there. Pieces
// with given poses are joined by these. Moves the poses of joined pieces to the frame of the first,
// and lays those that are left side by side along x, each as if it began at the map's origin, with
// twice the sensor's range and more between them: nothing is known of how they lie to each other,
// and no scan of one may touch the map of another. Error: what reading a scan says.
Result<JoinedPieces> join_pieces(PassContext& ctx, const Drive& drive,
                                 const std::vector<std::optional<Pose>>& given, Odometry& odometry,
                                 const KnownPieces& known = {});

}  // namespace sightline
