#pragma once

#include "passes/trajectory/pieces/join_pieces.h"

namespace sightline {

// Refuses an odometry that could not follow more than a quarter of the steps, apart from jumps of
// stamps. Error: trajectory-lost; place: the first such scan.
Result<void> check_following(const Drive& drive, const Odometry& odometry);

// One warning for each piece that is not joined: its scan, time and place, and why it begins.
void warn_of_pieces(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                    const JoinedPieces& joined);

// One warning of the scans within pieces that could not be matched.
void warn_of_unmatched(const PassContext& ctx, const Odometry& odometry);

}  // namespace sightline
