#pragma once

#include <cstdint>
#include <span>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/pieces/seek_piece.h"

namespace sightline {

// A piece that would be joined to others.
struct PlacedPiece {
  ScanRange scans;
  Pose T_others_piece = Pose::Identity();  // from its odometry's frame to that of the others
  std::uint32_t from = 0;                  // the scan by which it was found there
};

// Since streets look alike, a few scans may fit a wrong place. Scans all along the piece that come
// near those of `others` are matched to maps of these; two thirds must fit. False where fewer than
// three come near (every 10 m of way), unless the piece has fewer. Shared by ctx.threads. Errors:
// those of reading a scan.
Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const PlacedPiece& placed);

}  // namespace sightline
