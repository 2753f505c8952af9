#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "passes/trajectory/pieces/place_key.h"
#include "passes/trajectory/pieces/seek_piece.h"

namespace sightline {

// The places of the pieces of one odometry, by their ring keys (place_key.h). Refers to its
// arguments.
class PlaceRecognition {
 public:
  PlaceRecognition(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                   std::span<const ScanRange> pieces)
      : ctx_(ctx), drive_(drive), odometry_(odometry), pieces_(pieces), keys_(pieces.size()) {}

  // The places of all pieces before `later` (middles_of), in order of the least difference to one
  // of the queries; of equal ones those of the later piece first, and of one piece from its end
  // back. Reads a scan in 5 m of a piece on first use. Error: that of reading a scan.
  Result<std::vector<std::uint32_t>> before(std::uint32_t later, const std::vector<Query>& queries);

 private:
  Result<void> read_keys(std::uint32_t piece);
  [[nodiscard]] double least_difference(std::uint32_t piece, std::uint32_t middle,
                                        const std::vector<PlaceKey>& wanted) const;

  const PassContext& ctx_;
  const Drive& drive_;
  const Odometry& odometry_;
  std::span<const ScanRange> pieces_;
  // By piece: scans and the keys of their places.
  std::vector<std::vector<std::pair<std::uint32_t, PlaceKey>>> keys_;
};

}  // namespace sightline
