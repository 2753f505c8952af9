#include "passes/replay/place_check.h"

#include <algorithm>
#include <span>

#include "formats/grid/cell_key.h"
#include "passes/matching/scan_preparation.h"
#include "passes/trajectory/local/local_map.h"

namespace sightline {
namespace {

// As scans are thinned to be compared with a map in align-drive (read_thinned).
constexpr double kLeaf_m = 0.5;
constexpr double kFarthest_m = 70.0;
// More returns than this say nothing more of a place and take time.
constexpr std::size_t kMostReturns = 40'000;

NdtMap map_of(const sightline_localizer_info& info) {
  NdtMap map;
  map.frame.origin_world_m = Eigen::Map<const Eigen::Vector3d>(info.origin_world_m);
  map.cell_m = info.cell_m;
  map.nds.reserve(info.nd_count);
  for (const sightline_nd& from : std::span(info.nds, info.nd_count)) {
    Nd& nd = map.nds.emplace_back();
    nd.point_count = from.point_count;
    nd.mean_m = Eigen::Map<const Eigen::Vector3d>(from.mean_world_m) - map.frame.origin_world_m;
    nd.key = cell_key(nd.mean_m, map.cell_m);
    const double* c = from.covariance_m2;
    nd.covariance_m2 << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  }
  decompose(map.nds);
  return map;
}

}  // namespace

std::vector<Eigen::Vector3d> upright_of(const Scan& scan, const SensorProfile& sensor) {
  const std::size_t stride = 1 + scan.points_m.size() / kMostReturns;
  const double farthest_m = std::min(sensor.max_range_m, kFarthest_m);
  std::vector<Eigen::Vector3d> within_m;
  within_m.reserve(scan.points_m.size() / stride + 1);
  for (std::size_t i = 0; i < scan.points_m.size(); i += stride) {
    const double range_m = scan.points_m[i].norm();
    if (range_m >= sensor.min_range_m && range_m <= farthest_m) {
      within_m.push_back(scan.points_m[i]);
    }
  }
  std::vector<Eigen::Vector3d> upright_m =
      upright_points(voxel_subsample(within_m, kLeaf_m), sensor.T_vehicle_lidar.linear());
  for (Eigen::Vector3d& point_m : upright_m) point_m = sensor.T_vehicle_lidar * point_m;
  return upright_m;
}

PlaceCheck::PlaceCheck(const sightline_localizer_info& map) : map_(map_of(map)), nds_(map_) {}

std::optional<double> PlaceCheck::met_share(const std::vector<Eigen::Vector3d>& upright_m,
                                            const Pose& T_world_vehicle) const {
  return sightline::met_share(nds_, upright_m, rebase(T_world_vehicle, MapFrame{}, map_.frame));
}

}  // namespace sightline
