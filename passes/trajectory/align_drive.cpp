#include "passes/trajectory/align_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "formats/geometry.h"
#include "passes/pass/tile_digests.h"
#include "passes/pass/work_in_parts.h"
#include "passes/trajectory/drive_on_map.h"
#include "passes/trajectory/following/followed_scans.h"
#include "passes/trajectory/graph/pose_graph.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/place_drive.h"

namespace sightline {
namespace {

// Errors of a match with the map, which is made of another day's scans; and of one own step.
constexpr double kMatchSigma_m = 0.03;
constexpr double kMatchSigma_rad = 0.002;
constexpr double kStepSigma_m = 0.005;
constexpr double kStepSigma_rad = 0.0005;

// The poses of a drive in the map; scans of a piece that is not found are far from it.
struct Followed {
  std::vector<Pose> T_map_lidar;
  std::vector<std::uint8_t> is_matched;
  std::vector<std::uint8_t> is_placed;
  double scale = 1.0;  // of the drive's distances to the map's
};
SIGHTLINE_FIELDS(Followed, T_map_lidar, is_matched, is_placed, scale)

// Moves a piece of a drive that is found nowhere in a map to where no site and no other scan is, 2
// km beyond along x.
void separate_piece(const std::vector<Pose>& T_own_lidar, const ScanRange& piece,
                    const Sites& sites, std::vector<Pose>& T_map_lidar) {
  constexpr double kApart_m = 2000.0;
  double farthest_m = 0.0;
  for (const Site& site : sites.sites) farthest_m = std::max(farthest_m, site.p_map_m.x());
  for (const Pose& pose : T_map_lidar) farthest_m = std::max(farthest_m, pose.translation().x());
  double lowest_m = T_own_lidar[piece.begin].translation().x();
  for (std::size_t k = piece.begin; k < piece.end; ++k) {
    lowest_m = std::min(lowest_m, T_own_lidar[k].translation().x());
  }
  for (std::size_t k = piece.begin; k < piece.end; ++k) {
    T_map_lidar[k] = T_own_lidar[k];
    T_map_lidar[k].translation().x() += farthest_m + kApart_m - lowest_m;
  }
}

// Matches from the anchor to both ends of its piece, each scan from where its neighbour's match
// leads.
Result<void> follow(PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                    const std::vector<Pose>& T_own_lidar, const ScanRange& piece,
                    const Placement& placement, Followed& followed) {
  std::size_t done = piece.begin;
  const auto visit = [&](std::size_t k, const Pose& T_map_own) -> Result<Pose> {
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k, ThinnedFor::kMatch));
    const Pose start = T_map_own * T_own_lidar[k];
    const MapMatch found = match_to_map(grid, scan.to_match_m, start);
    const bool is_matched = found.is_good && is_same_place(found.T_map_lidar, start);
    followed.is_matched[k] = is_matched ? 1 : 0;
    followed.T_map_lidar[k] = is_matched ? found.T_map_lidar : start;
    ctx.progress(std::min(++done, drive.scans.size()), drive.scans.size());
    return Pose(followed.T_map_lidar[k] * T_own_lidar[k].inverse());
  };
  Pose T_map_own = placement.T_map_own;
  for (std::size_t k = placement.anchor; k < piece.end; ++k) {
    SIGHTLINE_ASSIGN(T_map_own, visit(k, T_map_own));
  }
  T_map_own = followed.T_map_lidar[placement.anchor] * T_own_lidar[placement.anchor].inverse();
  for (std::size_t k = placement.anchor; k-- > piece.begin;) {
    SIGHTLINE_ASSIGN(T_map_own, visit(k, T_map_own));
  }
  return {};
}

// A drive and the map that it is aligned with.
struct Alignment {
  const AlignDriveOptions& options;
  const Drive& drive;
  const Sites& sites;
  const NdtMap& map;
  const std::vector<ScanRange>& pieces;
  const std::vector<Pose>& T_own_lidar;
};

Result<Followed> follow_pieces(PassContext& ctx, const Alignment& alignment, Followed followed) {
  const Drive& drive = alignment.drive;
  const MatchGrid grid = make_match_grid(alignment.map, surface_information_per_m2);
  const std::vector<Pose> places =
      sensor_places(alignment.sites, alignment.options.candidate_step_m);
  for (std::size_t i = 0; i < alignment.pieces.size(); ++i) {
    const ScanRange& piece = alignment.pieces[i];
    SIGHTLINE_ASSIGN(const std::optional<Placement> placement,
                     place_piece(ctx, grid, drive, piece, alignment.T_own_lidar, places));
    followed.is_placed[i] = placement ? 1 : 0;
    if (placement) {
      SIGHTLINE_TRY(follow(ctx, grid, drive, alignment.T_own_lidar, piece, *placement, followed));
    } else {
      separate_piece(alignment.T_own_lidar, piece, alignment.sites, followed.T_map_lidar);
    }
  }
  SIGHTLINE_ASSIGN(followed.scale,
                   scale_against_map(ctx, grid, drive, followed.T_map_lidar, followed.is_matched));
  return followed;
}

// The digest of all that follow_pieces() depends on; none where a scan has no identity.
std::optional<Digest> content_of(const Alignment& alignment, const TileDigests& nds,
                                 const Trajectory& own) {
  ByteWriter writer;
  encode(alignment.drive.sensor, writer);
  for (std::size_t k = 0; k < alignment.drive.scans.size(); ++k) {
    const std::optional<Digest> scan = alignment.drive.store->identity(k);
    if (!scan) return std::nullopt;
    writer.put_array(std::span<const std::uint8_t>(*scan));
  }
  DigestBuilder builder;
  builder.add(writer.bytes());
  builder.add(to_bytes(own));
  builder.add(to_bytes(alignment.sites));
  std::vector<Eigen::Vector3d> nds_m;
  for (const Nd& nd : alignment.map.nds) nds_m.push_back(nd.mean_m);
  builder.add(nds.within(box_around(nds_m, 0.0)));
  return builder.finish();
}

// The result of follow_pieces(), or of an earlier run of it in an unchanged map.
Result<Followed> follow_or_find(PassContext& ctx, const Alignment& alignment,
                                const TileDigests& nds, const Trajectory& own) {
  Followed followed{std::vector<Pose>(alignment.drive.scans.size(), Pose::Identity()),
                    std::vector<std::uint8_t>(alignment.drive.scans.size()),
                    std::vector<std::uint8_t>(alignment.pieces.size())};
  PassContext of_parts = ctx;
  of_parts.progress_sink = {};  // scans are counted
  RecordWork<Followed> work;
  work.count = 1;
  work.content = [&](std::size_t /*part*/) { return content_of(alignment, nds, own); };
  work.make = [&](std::size_t /*part*/, int /*threads*/) {
    return follow_pieces(ctx, alignment, followed);
  };
  work.take = [&](std::size_t /*part*/, Followed found) {
    const bool is_of_these = found.T_map_lidar.size() == followed.T_map_lidar.size() &&
                             found.is_matched.size() == followed.is_matched.size() &&
                             found.is_placed.size() == followed.is_placed.size();
    if (is_of_these) followed = std::move(found);
    return is_of_these;
  };
  SIGHTLINE_TRY(work_in_parts(of_parts, work));
  return followed;
}

PoseGraph graph_of(const Followed& followed, const std::vector<ScanRange>& pieces,
                   const std::vector<Pose>& T_own_lidar) {
  PoseGraph graph;
  for (const ScanRange& piece : pieces) {
    const auto of_piece =
        std::span(followed.is_matched).subspan(piece.begin, piece.end - piece.begin);
    if (std::ranges::count(of_piece, 1) == 0) graph.held.push_back(piece.begin);
  }
  std::size_t next = 0;
  for (std::uint32_t k = 0; k < T_own_lidar.size(); ++k) {
    if (next < pieces.size() && pieces[next].begin == k) {
      ++next;
    } else {
      graph.odometry.push_back(
          {k - 1, k, T_own_lidar[k - 1].inverse() * T_own_lidar[k], kStepSigma_m, kStepSigma_rad});
    }
    if (followed.is_matched[k] != 0) {
      graph.priors.push_back({k, followed.T_map_lidar[k], kMatchSigma_m, kMatchSigma_rad});
    }
  }
  return graph;
}

Trajectory trajectory_of(const Drive& drive, const NdtMap& map, const PoseGraph& graph,
                         const GraphSolution& solution) {
  Trajectory trajectory = solved_trajectory(map.frame, graph, solution);
  trajectory.source = PoseSource::kEstimated;  // by matches to the map
  const Pose T_lidar_vehicle = drive.sensor.T_vehicle_lidar.inverse();
  // Neighbours match the same walls: together they are no better than one match.
  PoseCovariance::Matrix of_a_match = PoseCovariance::Matrix::Zero();
  of_a_match.diagonal().head<3>().setConstant(kMatchSigma_m * kMatchSigma_m);
  of_a_match.diagonal().tail<3>().setConstant(kMatchSigma_rad * kMatchSigma_rad);
  const PoseCovariance covariance = of_a_match;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    TrajectoryPose pose{drive.scans[k].recording_index, drive.scans[k].stamp_ns,
                        solution.T_map_pose[k] * T_lidar_vehicle};
    pose.covariance = covariance;
    trajectory.poses.push_back(pose);
  }
  return trajectory;
}

void warn_of_unmatched(const PassContext& ctx, const Drive& drive, const Followed& followed) {
  const auto unmatched = std::ranges::count(followed.is_matched, 0);
  if (unmatched == 0) return;
  ctx.warn(
      fmt::format("{} of {} scans of drive {} do not match the map; their poses are interpolated "
                  "from the drive's own trajectory",
                  unmatched, drive.scans.size(), drive.name));
}

void warn_of_scale(const PassContext& ctx, const Drive& drive, double scale) {
  if (scale == 1.0) return;
  ctx.warn(
      fmt::format("drive {} measures distances {:.1f} % {} than in the map, so its localization "
                  "errors are too large. Check the range calibration of both sensors",
                  drive.name, 100.0 * std::abs(scale - 1.0), scale > 1.0 ? "longer" : "shorter"));
}

// "x (east) 0.30 m, y (north) 0.02 m, up 0.00 m"; of the vehicle: "forward 0.30 m, ...".
std::string in_words(const PoseOffset& offset) {
  const Eigen::Vector3d& by_m = offset.offset_m;
  return offset.is_of_vehicle ? fmt::format("forward {:.2f} m, left {:.2f} m, up {:.2f} m",
                                            by_m.x(), by_m.y(), by_m.z())
                              : fmt::format("x (east) {:.2f} m, y (north) {:.2f} m, up {:.2f} m",
                                            by_m.x(), by_m.y(), by_m.z());
}

// Known poses are kept, but for a constant offset from the map's where that is to be subtracted.
Result<Trajectory> keep_given(PassContext& ctx, const AlignDriveOptions& options,
                              const Drive& drive, Trajectory own, const TiledNds& nds,
                              const Sites& sites) {
  if (nds.row_count() == 0) return own;
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, own));
  const std::vector<Pose> T_map_lidar = sensor_poses(drive, rebase(own, nds.head().frame));
  SIGHTLINE_ASSIGN(const std::vector<ScanOnMap> scans,
                   scans_on_map(ctx, drive, T_map_lidar, nds, sites));
  SIGHTLINE_TRY(check_shows_map(drive, scans));
  const std::optional<PoseOffset> offset = constant_offset(drive, scans, T_map_lidar);
  if (!offset) return own;
  const std::string difference =
      fmt::format("poses of drive {} differ from the map by {:.2f} m ({}) at all places",
                  drive.name, offset->offset_m.norm(), in_words(*offset));
  if (!options.subtracts_offset) {
    ctx.warn(concat(difference,
                    "; localization errors against them contain this offset. Check the origins and "
                    "the sensor mountings of both drives, or set align: true for this drive"));
    return own;
  }
  ctx.inform(concat(difference, "; it is subtracted (align: true)"));
  for (TrajectoryPose& pose : own.poses) {
    const Eigen::Vector3d by_m =
        offset->is_of_vehicle ? Eigen::Vector3d(pose.T_map_vehicle.linear() * offset->offset_m)
                              : offset->offset_m;
    pose.T_map_vehicle.translation() -= by_m;
  }
  return own;
}

// Error: no-overlap where no piece is placed, or the scans do not show this map.
Result<Trajectory> align_pieces(PassContext& ctx, const AlignDriveOptions& options,
                                const Drive& drive, const Trajectory& own, const TiledNds& nds,
                                const Sites& sites) {
  const bool is_given = own.source == PoseSource::kGiven;
  if (options.mode == AlignMode::kGiven) return own;
  if (options.mode == AlignMode::kAuto && is_given) {
    return keep_given(ctx, options, drive, own, nds, sites);
  }
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, own));
  if (nds.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap, "the map has no ND to match"};
  }
  // A drive may be anywhere on the map.
  SIGHTLINE_ASSIGN(const NdtMap map, nds.whole());
  const Trajectory near = rebase(own, map.frame);
  const std::vector<Pose> T_own_lidar = sensor_poses(drive, near);
  std::vector<std::uint32_t> numbers;
  for (const TrajectoryPose& pose : own.poses) numbers.push_back(pose.piece);
  const std::vector<ScanRange> pieces = ranges_of(numbers);
  SIGHTLINE_ASSIGN(const TileDigests tiles, digests_of(nds));
  const Alignment alignment{options, drive, sites, map, pieces, T_own_lidar};
  SIGHTLINE_ASSIGN(const Followed followed, follow_or_find(ctx, alignment, tiles, own));
  if (std::ranges::count(followed.is_placed, 1) == 0) {
    return Error{ErrorCode::kNoOverlap, "no two scans match the map at consistent positions", "",
                 "drive " + drive.name};
  }
  SIGHTLINE_ASSIGN(const std::vector<ScanOnMap> scans,
                   scans_on_map(ctx, drive, followed.T_map_lidar, nds, sites));
  SIGHTLINE_TRY(check_shows_map(drive, scans));
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (followed.is_placed[i] != 0) continue;
    ctx.warn(concat("scans ", drive.scans[pieces[i].begin].recording_index, " to ",
                    drive.scans[pieces[i].end - 1].recording_index, " of drive ", drive.name,
                    ", a separate piece of its trajectory, do not match the map and are left out"));
  }
  warn_of_unmatched(ctx, drive, followed);
  warn_of_scale(ctx, drive, followed.scale);
  const PoseGraph graph = graph_of(followed, pieces, T_own_lidar);
  SIGHTLINE_ASSIGN(const GraphSolution solution, solve_pose_graph(graph, followed.T_map_lidar));
  return trajectory_of(drive, map, graph, solution);
}

// The whole drive, away from all sites. Vehicle poses in place of the sensor's: the exact place
// does not matter.
Trajectory placed_aside(const Trajectory& own, const MapFrame& frame, const Sites& sites) {
  Trajectory aside = rebase(own, frame);
  std::vector<Pose> T_own_vehicle;
  for (const TrajectoryPose& pose : aside.poses) T_own_vehicle.push_back(pose.T_map_vehicle);
  std::vector<Pose> T_map_vehicle(T_own_vehicle.size(), Pose::Identity());
  const auto count = static_cast<std::uint32_t>(T_own_vehicle.size());
  separate_piece(T_own_vehicle, {0, count}, sites, T_map_vehicle);
  for (std::size_t k = 0; k < aside.poses.size(); ++k) {
    aside.poses[k].T_map_vehicle = T_map_vehicle[k];
  }
  return aside;
}

}  // namespace

std::vector<OptionField> option_fields(AlignDriveOptions& options) {
  return {
      choice(
          "mode", options.mode,
          "auto: drives without given poses are matched to the map; align: all drives; given: none",
          {"auto", "given", "align"}),
      number("candidate_step_m", options.candidate_step_m,
             "distance along the route between the places where the drive is searched for, m", 0.5,
             50.0),
      shared(flag("may_be_elsewhere", options.may_be_elsewhere,
                  "allow drives that are not in the map")),
      shared(flag("subtracts_offset", options.subtracts_offset,
                  "subtract a constant offset of given poses from the map's"))};
}

Result<Trajectory> align_drive(PassContext& ctx, const AlignDriveOptions& options,
                               const Drive& drive, const Trajectory& own, const TiledNds& nds,
                               const Sites& sites) {
  Result<Trajectory> aligned = align_pieces(ctx, options, drive, own, nds, sites);
  const bool is_elsewhere = !aligned && aligned.error().code == ErrorCode::kNoOverlap;
  if (!is_elsewhere || !options.may_be_elsewhere || own.poses.empty()) return aligned;
  ctx.warn(concat("drive '", drive.name, "' does not match the map (", aligned.error().message,
                  ") and is placed apart from it"));
  return placed_aside(own, nds.head().frame, sites);
}

}  // namespace sightline
