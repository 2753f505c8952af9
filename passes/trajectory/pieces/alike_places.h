#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "passes/trajectory/pieces/place_key.h"
#include "passes/trajectory/pieces/seek_piece.h"

// Where to look for a piece first; part of estimate-trajectory.

namespace sightline {

// The places of the pieces of one odometry, by what they look like. Refers to what it is made of.
class AlikePlaces {
 public:
  AlikePlaces(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
              std::span<const ScanRange> pieces)
      : ctx_(ctx), drive_(drive), odometry_(odometry), pieces_(pieces), keys_(pieces.size()) {}

  // The places of all pieces before `later` (middles_of), those first that look most like one of
  // the queries; where they look alike, those of the later piece, and of one piece from its end
  // back. Reads a scan in 5 m of a piece when it is first asked about. Error: what reading a scan
  // says.
  Result<std::vector<std::uint32_t>> before(std::uint32_t later, const std::vector<Query>& queries);

 private:
  Result<void> read_keys(std::uint32_t piece);
  [[nodiscard]] double least_difference(std::uint32_t piece, std::uint32_t middle,
                                        const std::vector<PlaceKey>& wanted) const;

  const PassContext& ctx_;
  const Drive& drive_;
  const Odometry& odometry_;
  std::span<const ScanRange> pieces_;
  // By piece: scans and what their places look like.
  std::vector<std::vector<std::pair<std::uint32_t, PlaceKey>>> keys_;
};

}  // namespace sightline
