#include "passes/trajectory/drive_on_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/grid/cell_index.h"
#include "formats/grid/point_grid.h"
#include "formats/symmetric_eigen.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/pass/tile_digests.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/scan_constraint.h"
#include "passes/trajectory/met_share.h"
#include "passes/trajectory/place_drive.h"

namespace sightline {
namespace {

constexpr std::size_t kComparedScans = 16;
constexpr double kNearSite_m = 10.0;
// NDs around a scan: beyond the upright returns that are compared.
constexpr double kAround_m = 60.0;
// Where fewer returns meet the map than nearly always in the right place, other starts are tried:
// planes 5 cm thick do not pull a scan that is 0.3 m off. If it still does not fit, starts farther
// around.
constexpr double kSurelyMet = 0.75;
constexpr double kNearStep_m = 0.5;
constexpr double kReach_m = 3.0;

// As for two drives that make one map (pieces/seek_piece.cpp).
constexpr double kLeastMet = 0.5;

// A drive shows the map if so many of its scans do.
constexpr std::size_t kFewestScans = 5;
constexpr double kLeastShare = 0.2;

// Weight of a surface: the error of one that does not average out over its points.
constexpr double kSurface_m = 0.03;
// A normal's component below this is noise: sin(10 degrees).
constexpr double kLeastComponent = 0.17;

// An offset is named from here on, if its residuals are this share of it or less.
constexpr double kLeastOffset_m = 0.05;
constexpr double kMostScatter = 0.5;
constexpr double kSignificant = 3.0;  // standard errors
// So many scans constrain every direction that an offset is named in.
constexpr double kFewestConstraining = 4.0;

// The NDs around a scan.
struct NdsAround {
  explicit NdsAround(const NdtMap& map)
      : by_cell(map), grid(make_match_grid(map, surface_information_per_m2)) {}

  NdsByCell by_cell;
  MatchGrid grid;
};

// The directions of space that the surfaces and lines which the points meet constrain to
// kWeakBesideGiven_m; one observation an ND.
Eigen::Matrix3d constrained_directions(const NdsAround& nds,
                                       const std::vector<Eigen::Vector3d>& points_m,
                                       const Pose& T_map_lidar) {
  CellTable<std::uint8_t> counted;
  std::vector<Eigen::Vector3d> normals;
  for (const Eigen::Vector3d& point_lidar_m : points_m) {
    const Eigen::Vector3d point_m = T_map_lidar * point_lidar_m;
    nds.by_cell.visit_near(point_m, [&](const Nd& nd) {
      const bool is_line = is_upright_line(nd);
      if ((!is_line && !is_surface(nd)) || !meets(nd, point_m)) return;
      if (!counted.insert(nd.key, 1).is_new) return;
      normals.emplace_back(nd.eigenvectors.col(2));
      if (is_line) normals.emplace_back(nd.eigenvectors.col(1));
    });
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& normal : normals) sum += normal * normal.transpose();
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(sum);
  Eigen::Matrix3d projector = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d direction = eigen.vectors.col(i);
    double clear = 0.0;
    for (const Eigen::Vector3d& normal : normals) {
      const double part = normal.dot(direction);
      if (std::abs(part) >= kLeastComponent) clear += part * part;
    }
    const double sigma_m = kSurface_m / std::sqrt(std::max(clear, 1e-9));
    if (sigma_m <= kWeakBesideGiven_m) projector += direction * direction.transpose();
  }
  return projector;
}

// A match, and whether the scan shows the map there.
ScanOnMap matched_from(const NdsAround& nds, const ThinnedScan& scan,
                       const std::vector<Eigen::Vector3d>& upright_m, const Pose& T_map_start) {
  const MapMatch match = match_to_map(nds.grid, scan.to_match_m, T_map_start);
  ScanOnMap found;
  found.T_map_lidar = match.T_map_lidar;
  found.met_share = met_share(nds.by_cell, upright_m, match.T_map_lidar);
  found.fits = match.is_good && found.met_share.value_or(0.0) >= kLeastMet;
  return found;
}

// Two steps to each side in the sensor's plane.
std::vector<Pose> starts_beside(const Pose& T_map_lidar) {
  std::vector<Pose> starts;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      if (x == 0 && y == 0) continue;
      starts.push_back(T_map_lidar * Eigen::Translation3d(kNearStep_m * x, kNearStep_m * y, 0.0));
    }
  }
  return starts;
}

Result<ScanOnMap> scan_on_map(const Drive& drive, std::size_t k, const Pose& T_map_lidar,
                              const TiledNds& nds) {
  SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k, ThinnedFor::kMatch));
  const std::vector<Eigen::Vector3d> upright_m =
      upright_points(scan.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  const std::vector<Eigen::Vector3d> place_m = {T_map_lidar.translation()};
  SIGHTLINE_ASSIGN(const NdtMap map, nds.over(box_around(place_m, kAround_m)));
  const NdsAround around(map);
  ScanOnMap best = matched_from(around, scan, upright_m, T_map_lidar);
  const auto try_from = [&](const std::vector<Pose>& starts) {
    for (const Pose& start : starts) {
      const ScanOnMap found = matched_from(around, scan, upright_m, start);
      const bool is_better =
          found.fits == best.fits ? found.met_share > best.met_share : found.fits;
      if (is_better) best = found;
    }
  };
  if (best.met_share.value_or(0.0) < kSurelyMet) try_from(starts_beside(T_map_lidar));
  if (!best.fits) try_from(starts_around(T_map_lidar, kReach_m));
  best.scan = k;
  if (best.fits) {
    best.constrained = constrained_directions(around, scan.to_match_m, best.T_map_lidar);
  }
  return best;
}

std::vector<std::size_t> scans_near_sites(const std::vector<Pose>& T_map_lidar,
                                          const Sites& sites) {
  std::vector<Eigen::Vector3d> places_m;
  for (const Site& site : sites.sites) places_m.push_back(site.p_map_m);
  const PointGrid grid(places_m);
  std::vector<std::size_t> near;
  for (std::size_t k = 0; k < T_map_lidar.size(); ++k) {
    if (grid.nearest(T_map_lidar[k].translation(), kNearSite_m)) near.push_back(k);
  }
  return near;
}

// What one scan tells of a constant offset.
struct OffsetOfScan {
  Eigen::Vector3d offset_m;
  Eigen::Matrix3d constrained;
};

struct CommonOffset {
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  double scatter_m = 0.0;  // median distance of the scans' offsets from it
};

double residual_m(const OffsetOfScan& one, const Eigen::Vector3d& offset_m) {
  return (one.constrained * (one.offset_m - offset_m)).norm();
}

// Geometric median over what each constrains (Weiszfeld's algorithm).
CommonOffset common_offset(const std::vector<OffsetOfScan>& all) {
  constexpr int kRounds = 30;
  constexpr double kLeastResidual_m = 0.002;
  CommonOffset common;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d count = Eigen::Matrix3d::Zero();
    Eigen::Vector3d weighted_m = Eigen::Vector3d::Zero();
    for (const OffsetOfScan& one : all) {
      const double weight =
          round == 0 ? 1.0 : 1.0 / std::max(residual_m(one, common.offset_m), kLeastResidual_m);
      sum += weight * one.constrained;
      count += one.constrained;
      weighted_m += weight * (one.constrained * one.offset_m);
    }
    const SymmetricEigen<3> eigen = symmetric_eigen<3>(count);
    common.offset_m.setZero();
    Eigen::Matrix3d known = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d direction = eigen.vectors.col(i);
      if (eigen.values[i] >= kFewestConstraining) known += direction * direction.transpose();
    }
    // Directions that too few scans constrain are held at 0.
    const Eigen::Matrix3d held = known * sum * known + (Eigen::Matrix3d::Identity() - known);
    common.offset_m = held.ldlt().solve(known * weighted_m);
  }
  std::vector<double> residuals_m;
  for (const OffsetOfScan& one : all) residuals_m.push_back(residual_m(one, common.offset_m));
  std::ranges::sort(residuals_m);
  common.scatter_m = quantile_of_sorted(residuals_m, 0.5);
  return common;
}

}  // namespace

Result<std::vector<ScanOnMap>> scans_on_map(const PassContext& ctx, const Drive& drive,
                                            const std::vector<Pose>& T_map_lidar,
                                            const TiledNds& nds, const Sites& sites) {
  const std::vector<std::size_t> near = scans_near_sites(T_map_lidar, sites);
  const std::vector<std::size_t> chosen = evenly(near.size(), kComparedScans);
  return parallel_results<ScanOnMap>(chosen.size(), ctx.threads, [&](std::size_t i) {
    const std::size_t k = near[chosen[i]];
    return scan_on_map(drive, k, T_map_lidar[k], nds);
  });
}

Result<void> check_shows_map(const Drive& drive, const std::vector<ScanOnMap>& scans) {
  std::size_t compared = 0;
  std::size_t fitting = 0;
  for (const ScanOnMap& scan : scans) {
    compared += scan.met_share ? 1 : 0;
    fitting += scan.fits ? 1 : 0;
  }
  const double least = kLeastShare * static_cast<double>(compared);
  if (compared < kFewestScans || static_cast<double>(fitting) >= least) return {};
  return Error{ErrorCode::kNoOverlap,
               fmt::format("the drive does not show this map: {} of {} compared scans match its "
                           "walls and poles at their poses, expected at least a fifth",
                           fitting, compared),
               "", "drive " + drive.name};
}

std::optional<PoseOffset> constant_offset(const Drive& drive, const std::vector<ScanOnMap>& scans,
                                          const std::vector<Pose>& T_map_lidar) {
  std::vector<OffsetOfScan> of_map;
  std::vector<OffsetOfScan> of_vehicle;
  const Eigen::Matrix3d lidar_to_vehicle = drive.sensor.T_vehicle_lidar.linear().transpose();
  for (const ScanOnMap& scan : scans) {
    if (!scan.fits) continue;
    const Pose& T_map_given = T_map_lidar[scan.scan];
    const Eigen::Vector3d offset_m = T_map_given.translation() - scan.T_map_lidar.translation();
    const Eigen::Matrix3d turn = (T_map_given.linear() * lidar_to_vehicle).transpose();
    of_map.push_back({offset_m, scan.constrained});
    of_vehicle.push_back({turn * offset_m, turn * scan.constrained * turn.transpose()});
  }
  if (static_cast<double>(of_map.size()) < kFewestConstraining) return std::nullopt;
  const CommonOffset in_map = common_offset(of_map);
  const CommonOffset in_vehicle = common_offset(of_vehicle);
  constexpr double kClearlyLess = 0.7;
  const bool is_of_vehicle = in_vehicle.scatter_m < kClearlyLess * in_map.scatter_m;
  const CommonOffset& common = is_of_vehicle ? in_vehicle : in_map;
  const double size_m = common.offset_m.norm();
  const double error_m = common.scatter_m / std::sqrt(static_cast<double>(of_map.size()));
  const bool is_named = size_m > kLeastOffset_m && common.scatter_m <= kMostScatter * size_m &&
                        size_m > kSignificant * error_m;
  if (!is_named) return std::nullopt;
  return PoseOffset{common.offset_m, is_of_vehicle};
}

}  // namespace sightline
