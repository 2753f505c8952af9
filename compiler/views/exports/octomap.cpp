#include "compiler/views/exports/octomap.h"

#include <octomap/OcTree.h>
#include <octomap/Pointcloud.h>

#include <algorithm>
#include <sstream>

#include "compiler/views/exports/export_frame.h"
#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "formats/text/table.h"

// Rays take nearly all of the time and do not depend on each other: the voxels that a scan speaks
// of are found for several scans at once, and the tree is then updated scan by scan, in their
// order.

namespace sightline {
namespace {

// Scans whose voxels are held at once. A scan of a 64-beam sensor speaks of a million voxels.
constexpr std::size_t kScansAtOnce = 8;

octomap::point3d to_octomap(const Eigen::Vector3d& p_m) {
  return {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())};
}

// What one scan says of the voxels: none is in both.
struct ScanVoxels {
  octomap::KeySet free = octomap::KeySet();
  octomap::KeySet occupied = octomap::KeySet();
};

// Finds the voxels of scans, with a tree of its own that stays empty: OctoMap's rays need a tree's
// grid and write into its buffers.
class ScanLooker {
 public:
  ScanLooker(const SurfacePointReader& reader, const SurfacePoints& surface,
             const OctomapOptions& options)
      : reader_(reader),
        surface_(surface),
        options_(options),
        frame_(octomap_frame(surface.frame, options.voxel_m)),
        grid_(options.voxel_m) {}

  Result<ScanVoxels> look(std::size_t part) {
    SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> standing_m, reader_.standing(part));
    SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> moving_m, reader_.moving(part));
    const Eigen::Vector3d& shift_m = frame_.shift_m;
    for (Eigen::Vector3d& end_m : standing_m) end_m += shift_m;
    for (Eigen::Vector3d& end_m : moving_m) end_m += shift_m;
    const Eigen::Vector3d origin_m = surface_.scans[part].T_map_lidar.translation() + shift_m;
    if (!reaches(origin_m)) return too_far(origin_m);
    octomap::Pointcloud ends;
    ends.reserve(standing_m.size());
    for (const Eigen::Vector3d& end_m : standing_m) {
      if (!reaches(end_m)) return too_far(end_m);
      ends.push_back(to_octomap(end_m));
    }
    ScanVoxels found;
    grid_.computeUpdate(ends, to_octomap(origin_m), found.free, found.occupied,
                        options_.max_range_m);
    for (const Eigen::Vector3d& end_m : moving_m) {
      if (!reaches(end_m)) return too_far(end_m);
      add_way_to(end_m, origin_m, found);
    }
    return found;
  }

 private:
  [[nodiscard]] bool reaches(const Eigen::Vector3d& p_m) const {
    octomap::OcTreeKey key;
    return grid_.coordToKeyChecked(to_octomap(p_m), key);
  }

  [[nodiscard]] Error too_far(const Eigen::Vector3d& p_m) const {
    std::ostringstream text;
    text << "found a point at " << p_m.transpose() << " m; an octree of voxels of "
         << options_.voxel_m << " m reaches " << 32768.0 * options_.voxel_m
         << " m from its origin: use larger voxels (--leaf)";
    return Error{ErrorCode::kBadValue, text.str()};
  }

  void add_way_to(const Eigen::Vector3d& end_m, const Eigen::Vector3d& origin_m,
                  ScanVoxels& found) {
    const Eigen::Vector3d way_m = end_m - origin_m;
    const double shortened = std::min(1.0, options_.max_range_m / way_m.norm());
    octomap::KeyRay ray;
    grid_.computeRayKeys(to_octomap(origin_m), to_octomap(origin_m + shortened * way_m), ray);
    for (const octomap::OcTreeKey& key : ray) {
      if (found.occupied.count(key) == 0) found.free.insert(key);
    }
  }

  const SurfacePointReader& reader_;
  const SurfacePoints& surface_;
  const OctomapOptions& options_;
  OctomapFrame frame_;
  octomap::OcTree grid_;
};

Result<void> insert_scans(const SurfacePoints& surface, const OctomapOptions& options,
                          octomap::OcTree& tree) {
  const SurfacePointReader reader(surface);
  for (std::size_t first = 0; first < surface.scans.size(); first += kScansAtOnce) {
    const std::size_t count = std::min(kScansAtOnce, surface.scans.size() - first);
    std::vector<Result<ScanVoxels>> found(count, ScanVoxels{});
    parallel_for(count, options.threads, [&](std::size_t i) {
      found[i] = ScanLooker(reader, surface, options).look(first + i);
    });
    for (const Result<ScanVoxels>& scan : found) {
      if (!scan) return scan.error();
      for (const octomap::OcTreeKey& key : scan->free) tree.updateNode(key, false);
      for (const octomap::OcTreeKey& key : scan->occupied) tree.updateNode(key, true);
    }
  }
  return {};
}

// As OctoMap's writeBinary does, which prints on the way: the tree in its most likely state,
// pruned, after the head that its reader asks for.
std::vector<std::byte> to_bytes(const OctomapFrame& frame, octomap::OcTree& tree) {
  tree.toMaxLikelihood();
  tree.prune();
  std::ostringstream stream;
  stream << "# Octomap OcTree binary file\n"
         << "# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
         << "# coordinates: the recording's world minus ("
         << format_double(frame.origin_world_m.x()) << ", "
         << format_double(frame.origin_world_m.y()) << ", "
         << format_double(frame.origin_world_m.z()) << ") m\nid " << tree.getTreeType() << "\nsize "
         << tree.size() << "\nres " << format_double(tree.getResolution()) << "\ndata\n";
  tree.writeBinaryData(stream);
  ByteWriter writer;
  writer.append(stream.view().data(), stream.view().size());
  return writer.take();
}

}  // namespace

OctomapFrame octomap_frame(const MapFrame& frame, double voxel_m) {
  constexpr double kReach = 32768.0;  // voxels
  OctomapFrame found{export_origin_m(frame), export_shift_m(frame), true};
  // Half of it is left for the route.
  if (found.shift_m.cwiseAbs().maxCoeff() <= 0.5 * kReach * voxel_m) return found;
  return {frame.origin_world_m, Eigen::Vector3d::Zero(), false};
}

Result<std::vector<std::byte>> octomap_bt(const SurfacePoints& surface,
                                          const OctomapOptions& options) {
  if (!(options.voxel_m > 0.0 && options.max_range_m > 0.0)) {
    return Error{ErrorCode::kBadValue, "the voxel edge and the range must be above 0 m"};
  }
  octomap::OcTree tree(options.voxel_m);
  SIGHTLINE_TRY(insert_scans(surface, options, tree));
  if (tree.size() > 0) {
    return to_bytes(octomap_frame(surface.frame, options.voxel_m), tree);
  }
  return Error{ErrorCode::kEmptyMap, "found no returns in the scans"};
}

}  // namespace sightline
