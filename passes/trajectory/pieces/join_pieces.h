#pragma once

#include <cstdint>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"

namespace sightline {

struct JoinedPieces {
  std::vector<std::uint32_t> piece;  // of each scan, after joining; ascending from 0
  std::vector<PieceStart> starts;    // of every piece that is left, but the first
  std::vector<GraphEdge> edges;      // that join odometry's pieces, between scans
  std::vector<std::uint32_t> held;   // the first scan of each piece that is left, but the first
};

// Pieces whose places are known beforehand.
struct KnownPieces {
  // Of each a number; pieces of one number are right relative to each other. Empty: none is known.
  std::vector<std::uint32_t> number;
  std::uint32_t fixed = 0;  // so many of the first pieces are not moved
  std::size_t scans = 0;    // of these
};

// Joins pieces that measured one place: several scans of the later one, each searched for in maps
// of the earlier one at all headings, agree on its pose, and scans all along it fit there. Pieces
// with given poses are joined by these. Moves the poses of joined pieces to the frame of the first,
// and separates the remaining pieces along x, each as if it began at the map's origin, with twice
// the sensor's range and more between them: their relative poses are not known, and no scan of one
// may touch the map of another. Error: that of reading a scan.
Result<JoinedPieces> join_pieces(PassContext& ctx, const Drive& drive, const GivenPoses& given,
                                 Odometry& odometry, const KnownPieces& known = {});

// Refuses an odometry that could not follow more than a quarter of the steps, apart from jumps of
// stamps. Error: trajectory-lost; place: the first such scan.
Result<void> check_following(const Drive& drive, const Odometry& odometry);

// One warning for each piece that is not joined: its scan, time and place, and why it begins.
void warn_of_pieces(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                    const JoinedPieces& joined);

// One warning of the scans within pieces that could not be matched.
void warn_of_unmatched(const PassContext& ctx, const Odometry& odometry);

}  // namespace sightline
