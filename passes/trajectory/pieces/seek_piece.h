#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/local_map.h"

namespace sightline {

// Part of an earlier piece, as a map.
struct Visit {
  std::uint32_t middle = 0;  // scan
  LocalGrids grids;
  UprightMap upright{std::numeric_limits<double>::infinity()};
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
// The hypotheses that agree on the pose of the later piece; none where they are too few.
std::vector<Hypothesis> agreeing(const Odometry& odometry, const std::vector<Hypothesis>& found);

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
