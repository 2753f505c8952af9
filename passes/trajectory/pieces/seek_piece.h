#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/local_map.h"

// Where a piece is: the places that look like it, the poses that its scans find there, and whether
// it fits there all along.

namespace sightline {

// Part of an earlier piece, as a map.
struct Visit {
  std::uint32_t middle = 0;  // scan
  LocalGrids grids;
  UprightMap upright{std::numeric_limits<double>::infinity()};
  std::vector<Eigen::Vector3d> points_m;  // map frame
};
// Error: that of reading a scan.
Result<Visit> make_visit(const Drive& drive, const Odometry& odometry, const ScanRange& range,
                         std::uint32_t middle, int threads);
// Scans of a piece around which maps of it are made, from its end to its beginning.
std::vector<std::uint32_t> middles_of(const Odometry& odometry, const ScanRange& range);

// A scan that is searched for.
struct Query {
  std::uint32_t scan = 0;
  ThinnedScan thinned;
  std::vector<Eigen::Vector3d> upright_m;
};
// The queries of a piece: more of its beginning than of the rest. Error: that of reading a scan.
Result<std::vector<Query>> read_queries(const Drive& drive, const Odometry& odometry,
                                        const ScanRange& range);

// The pose of a query's scan in the frame of the earlier piece.
struct Hypothesis {
  std::uint32_t scan = 0;
  Pose T_map_lidar = Pose::Identity();
  double overlap = 0.0;
};
// Hypotheses of the queries that fit one place of the visit, and no other nearly as well.
std::vector<Hypothesis> look_for(const PassContext& ctx, const Visit& visit,
                                 const Odometry& odometry, const std::vector<Query>& queries);
struct FoundPiece {
  const Visit& visit;
  const std::vector<Query>& queries;
  const std::vector<Hypothesis>& agreed;  // of these
};
// The hypotheses that agree on the pose of the later piece; none where they are too few.
std::vector<Hypothesis> agreeing(const Odometry& odometry, const std::vector<Hypothesis>& found);

// A piece that would be joined to others.
struct PlacedPiece {
  ScanRange scans;
  Pose T_others_piece = Pose::Identity();  // from its odometry's frame to that of the others
  std::uint32_t from = 0;                  // the scan by which it was found there
};

// Whether half of the agreeing hypotheses fit as well on another level of `others`, with a surface
// between (is_surface_between): storeys look alike. Error: that of reading a scan.
Result<bool> fits_another_level(const PassContext& ctx, const Drive& drive,
                                const Odometry& odometry, std::span<const ScanRange> others,
                                const FoundPiece& found);

// Since streets look alike, a few scans may fit a wrong place. Scans all along the piece that come
// near those of `others` on their level are matched to maps of these; two thirds must fit. False
// where fewer than three come near (every 10 m of way), unless the piece has fewer. Shared by
// ctx.threads. Errors: those of reading a scan.
Result<bool> fits_all_along(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                            std::span<const ScanRange> others, const PlacedPiece& placed);

// The ring key of Scan Context (Kim and Kim, IROS 2018), by occupancy in place of height: of each
// ring of 2 m around the sensor, in how many of 60 directions something upright is. It does not
// depend on the heading, and similar places have similar keys: it decides where to search first,
// not where a scan is.
using PlaceKey = std::array<float, 20>;

// From a scan's upright points (upright_points), in the sensor's frame.
PlaceKey place_key(const std::vector<Eigen::Vector3d>& upright_m);

// Sum over the rings; 0 for equal keys.
double difference(const PlaceKey& a, const PlaceKey& b);

// The places of the pieces of one odometry, by their ring keys. Refers to its arguments.
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
