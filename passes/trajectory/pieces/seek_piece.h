#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/pass/pass_context.h"
#include "passes/trajectory/following/odometry.h"
#include "passes/trajectory/local/scan_overlap.h"

// Looking for scans of one piece in maps of another; part of estimate-trajectory.

namespace sightline {

struct ScanRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};
// Of each of odometry's pieces.
std::vector<ScanRange> ranges_of(const std::vector<std::uint32_t>& piece);

// Part of an earlier piece, as a map.
struct Visit {
  std::uint32_t middle = 0;  // scan
  LocalGrids grids;
  UprightMap upright{std::numeric_limits<double>::infinity()};
};
// Error: what reading a scan says.
Result<Visit> make_visit(const Drive& drive, const Odometry& odometry, const ScanRange& range,
                         std::uint32_t middle, int threads);
// Scans around which a piece is looked at, from its end to its beginning.
std::vector<std::uint32_t> middles_of(const Odometry& odometry, const ScanRange& range);

// A scan that is looked for.
struct Query {
  std::uint32_t scan = 0;
  ThinnedScan thinned;
  std::vector<Eigen::Vector3d> upright_m;
};
// Those of a piece: more of its beginning than of the rest. Error: what reading a scan says.
Result<std::vector<Query>> read_queries(const Drive& drive, const Odometry& odometry,
                                        const ScanRange& range);

// Where a query's scan lies in the frame of the earlier piece.
struct Hypothesis {
  std::uint32_t scan = 0;
  Pose T_map_lidar = Pose::Identity();
  double overlap = 0.0;
};
// Of the queries that fit one place of the visit, and that place alone.
std::vector<Hypothesis> look_for(const PassContext& ctx, const Visit& visit,
                                 const Odometry& odometry, const std::vector<Query>& queries);
// Those that agree on where the later piece lies; none where they are too few.
std::vector<Hypothesis> agreeing(const Odometry& odometry, const std::vector<Hypothesis>& found);

}  // namespace sightline
