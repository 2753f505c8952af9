#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "passes/trajectory/pieces/seek_piece.h"

namespace sightline {

// The ring key of Scan Context (Kim and Kim, IROS 2018), by occupancy in place of height: of each
// ring of 2 m around the sensor, in how many of 60 directions something upright is. It does not
// depend on the heading, and similar places have similar keys: it decides where to search first,
// not where a scan is.
using PlaceKey = std::array<float, 20>;

// From a scan's upright points (upright_points), in the sensor's frame.
PlaceKey place_key(const std::vector<Eigen::Vector3d>& upright_m);

// Sum over the rings; 0 for equal keys.
double difference(const PlaceKey& a, const PlaceKey& b);

// The places of the pieces of one odometry, by their ring keys. Refers to its
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
