#pragma once

#include <map>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/factors/virtual_scan.h"
#include "passes/pass/pass_context.h"
#include "passes/rays/surface_caster.h"

// The virtual scan and its information (schemas/definitions.md, "Factors from a virtual scan") at
// sites of a map of NDs alone, cast on the patches of passes/map/build_nd_surface.h.

namespace sightline {

// The NDs of a neighbourhood, found by cell.
struct NearNds {
  double cell_m = 2.0;
  std::vector<Nd> nds;
  std::vector<Eigen::Matrix3d> information_per_m2;  // inverse regularised covariance, of each
  CellIndex index;                                  // numbers them

  // Null where the cell has no valid ND.
  [[nodiscard]] const Eigen::Matrix3d* information_at(const CellKey& key) const;
};
// Those of `map` within reach_m of any of the places, in the plane.
NearNds nds_near(const NdtMap& map, const std::vector<Eigen::Vector3d>& places_m, double reach_m);

// A voxel of a scan before it becomes its centroid; from the sensor, map axes.
struct ScanVoxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
};

struct SiteView {
  std::size_t site = 0;
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  std::vector<double> distance_m;       // of each beam direction; +inf: it meets nothing, NaN: it
                                        // is out of view
  std::map<CellKey, ScanVoxel> voxels;  // of the scan thinned on the localizer's voxel grid
  Matrix6d information = Matrix6d::Zero();  // of the voxels' centroids
};

struct ViewOptions {
  double near_m = 0.5;
  double range_m = 50.0;  // nothing further is hit
  double leaf_m = 1.0;    // edge of the localizer's voxels
  AzimuthView view = {};  // of the sensor
};

// The views from sites of the list, in its order; `directions` as beam_directions() gives them.
Result<std::vector<SiteView>> views_from(PassContext& ctx, const ViewOptions& options,
                                         const NearNds& nds, const Sites& sites,
                                         const std::vector<std::size_t>& of,
                                         const std::vector<Eigen::Vector3d>& directions);

// Adds the information of a voxel's centroid, by the information of the ND that holds it (null:
// nothing); sign -1 takes it away.
void add_voxel(const ScanVoxel& voxel, const Eigen::Matrix3d* information_per_m2, double sign,
               Matrix6d& information);

// The cell that holds a voxel's centroid.
CellKey cell_of(const ScanVoxel& voxel, const Eigen::Vector3d& p_map_m, double cell_m);

}  // namespace sightline
