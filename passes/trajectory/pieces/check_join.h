#pragma once

#include <cstdint>
#include <span>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/pieces/seek_piece.h"

// Whether a piece lies right where a few of its scans say; part of estimate-trajectory.

namespace sightline {

// A piece that would be laid onto others.
struct LaidPiece {
  ScanRange scans;
  Pose T_others_piece = Pose::Identity();  // from its odometry's frame to that of the others
  std::uint32_t from = 0;                  // the scan by which it was found there
};

// Streets look alike: a few scans may fit a place that the others do not. Scans all along the piece
// that come near those of `others` are matched to what these saw there; most of them must meet it.
// False where fewer than three come near (every 10 m of way), unless the piece has fewer: who only
// touches the others may as well lie anywhere else. Shared by ctx.threads. Errors: what reading a
// scan says.
Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const LaidPiece& laid);

}  // namespace sightline
