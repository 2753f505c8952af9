#include "compiler/views/exports/octomap.h"

#include <octomap/OcTree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "compiler/views/exports/export_frame.h"
#include "compiler/views/exports/scan_blocks.h"
#include "compiler/views/exports/voxel_evidence.h"
#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "formats/text/table.h"

// OctoMap gives the grid, the rays and the file. The voxels of several scans are found at once,
// their evidence is summed by blocks, and the tree is built once, from what it comes to.

namespace sightline {
namespace {

// Scans whose voxels are held at once. A scan of a 64-beam sensor speaks of a million voxels.
constexpr std::size_t kScansAtOnce = 8;

octomap::point3d to_octomap(const Eigen::Vector3d& p_m) {
  return {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())};
}

Error too_far(const Eigen::Vector3d& p_m, double voxel_m) {
  std::ostringstream text;
  text << "found a point at " << p_m.transpose() << " m; an octree of voxels of " << voxel_m
       << " m reaches " << 32768.0 * voxel_m << " m from its origin: use larger voxels (--leaf)";
  return Error{ErrorCode::kBadValue, text.str()};
}

// The voxels of one scan, as OctoMap's computeUpdate() and computeRayKeys() find them.
class ScanCaster {
 public:
  // Of a tree only the grid is used.
  explicit ScanCaster(const OctomapOptions& options)
      : max_range_m_(options.max_range_m), grid_(options.voxel_m) {}

  // All points to come are in these voxels.
  void begin(const Eigen::Vector3d& origin_m, const CellKey& low, const CellKey& high) {
    blocks_.begin(low, high);
    origin_m_ = origin_m;
    from_ = voxel_of(origin_m);
  }

  // The voxel of a point; nothing where the grid ends.
  [[nodiscard]] std::optional<CellKey> voxel_of(const Eigen::Vector3d& p_m) const {
    return voxel_of(to_octomap(p_m));
  }

  // The end of the ray is occupied, or, beyond the range, its beginning is free.
  void add_return(const Eigen::Vector3d& end_m) {
    const octomap::point3d origin = to_octomap(origin_m_);
    const octomap::point3d way = to_octomap(end_m) - origin;
    if (way.norm() <= max_range_m_) {
      const std::optional<CellKey> voxel = free_way(to_octomap(end_m));
      if (voxel) blocks_.occupy(*voxel);
    } else {
      free_way(origin + way.normalized() * static_cast<float>(max_range_m_));
    }
  }

  // The way to what moved is free.
  void add_moving(const Eigen::Vector3d& end_m) {
    const Eigen::Vector3d way_m = end_m - origin_m_;
    const double shortened = std::min(1.0, max_range_m_ / way_m.norm());
    free_way(to_octomap(origin_m_ + shortened * way_m));
  }

  [[nodiscard]] const ScanBlocks& blocks() const { return blocks_; }

 private:
  [[nodiscard]] std::optional<CellKey> voxel_of(const octomap::point3d& p_m) const {
    octomap::OcTreeKey key;
    if (!grid_.coordToKeyChecked(p_m, key)) return std::nullopt;
    return CellKey{key[0], key[1], key[2]};
  }

  // In OctoMap's own order of operations on floats and doubles. Returns the voxel of the end.
  std::optional<CellKey> free_way(const octomap::point3d& end) {
    const octomap::point3d origin = to_octomap(origin_m_);
    const std::optional<CellKey> to = voxel_of(end);
    if (!from_ || !to || *from_ == *to) return to;
    octomap::point3d direction = end - origin;
    const auto length_m = static_cast<float>(direction.norm());
    direction /= length_m;
    VoxelRay ray{*from_, *to};
    ray.length_m = length_m;
    const std::array<std::int32_t, 3> voxel = {from_->x, from_->y, from_->z};
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double along = direction(axis);
      ray.step[axis] = along > 0.0 ? 1 : along < 0.0 ? -1 : 0;
      ray.next_m[axis] = ray.between_m[axis] = std::numeric_limits<double>::max();
      if (ray.step[axis] == 0) continue;
      double face_m = grid_.keyToCoord(static_cast<octomap::key_type>(voxel[axis]));
      face_m += static_cast<float>(ray.step[axis] * grid_.getResolution() * 0.5);
      ray.next_m[axis] = (face_m - origin(axis)) / along;
      ray.between_m[axis] = grid_.getResolution() / std::abs(along);
    }
    blocks_.free_along(ray);
    return to;
  }

  double max_range_m_;
  octomap::OcTree grid_;
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  std::optional<CellKey> from_;  // the origin's voxel
  ScanBlocks blocks_;
};

// Finds the voxels of a part.
Result<void> cast_scan(const SurfacePointReader& reader, std::size_t part, double voxel_m,
                       const Eigen::Vector3d& origin_m, const Eigen::Vector3d& shift_m,
                       ScanCaster& caster) {
  SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> standing_m, reader.standing(part));
  SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> moving_m, reader.moving(part));
  Eigen::AlignedBox3d box(origin_m);
  for (std::vector<Eigen::Vector3d>* points_m : {&standing_m, &moving_m}) {
    for (Eigen::Vector3d& end_m : *points_m) {
      end_m += shift_m;
      if (!caster.voxel_of(end_m)) return too_far(end_m, voxel_m);
      box.extend(end_m);
    }
  }
  caster.begin(origin_m, caster.voxel_of(box.min()).value(), caster.voxel_of(box.max()).value());
  for (const Eigen::Vector3d& end_m : standing_m) caster.add_return(end_m);
  for (const Eigen::Vector3d& end_m : moving_m) caster.add_moving(end_m);
  return {};
}

// Where the sensor was, in the octree's frame and in its voxels.
struct Origins {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<CellKey> voxels;
};

Result<Origins> sensor_origins(const SurfacePoints& surface, const OctomapOptions& options) {
  const Eigen::Vector3d shift_m = octomap_frame(surface.frame, options.voxel_m).shift_m;
  const ScanCaster grid(options);
  Origins origins;
  for (const PlacedScan& scan : surface.scans) {
    origins.positions_m.emplace_back(scan.T_map_lidar.translation() + shift_m);
    const std::optional<CellKey> voxel = grid.voxel_of(origins.positions_m.back());
    if (!voxel) return too_far(origins.positions_m.back(), options.voxel_m);
    origins.voxels.push_back(*voxel);
  }
  return origins;
}

RayModel default_model() {
  const octomap::OcTree tree(1.0);
  return {tree.getProbHitLog(), tree.getProbMissLog(), tree.getClampingThresMinLog(),
          tree.getClampingThresMaxLog(), tree.getOccupancyThresLog()};
}

Result<std::vector<SeenBlock>> see_scans(const SurfacePoints& surface,
                                         const OctomapOptions& options) {
  const SurfacePointReader reader(surface);
  const Eigen::Vector3d shift_m = octomap_frame(surface.frame, options.voxel_m).shift_m;
  SIGHTLINE_ASSIGN(const Origins origins, sensor_origins(surface, options));
  VoxelEvidence evidence(origins.voxels, options.max_range_m / options.voxel_m + 2.0,
                         default_model());
  std::vector<ScanCaster> casters(std::min(kScansAtOnce, surface.scans.size()),
                                  ScanCaster(options));
  for (std::size_t first = 0; first < surface.scans.size(); first += kScansAtOnce) {
    const std::size_t count = std::min(kScansAtOnce, surface.scans.size() - first);
    std::vector<Result<void>> cast(count);
    parallel_for(count, options.threads, [&](std::size_t i) {
      cast[i] = cast_scan(reader, first + i, options.voxel_m, origins.positions_m[first + i],
                          shift_m, casters[i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      SIGHTLINE_TRY(cast[i]);
      evidence.add(casters[i].blocks());
    }
  }
  return evidence.take();
}

// OctoMap makes the root of a tree when a node is set. Nodes are added to this one.
class RootedTree : public octomap::OcTree {
 public:
  explicit RootedTree(double voxel_m) : octomap::OcTree(voxel_m) {
    root = new octomap::OcTreeNode();  // the tree's own
    ++tree_size;
  }
};

// Builds a tree in its most likely state. Nodes of equal children have none.
class TreeOfBlocks {
 public:
  // Blocks are two levels of nodes.
  explicit TreeOfBlocks(octomap::OcTree& tree) : tree_(tree), depth_(tree.getTreeDepth() - 2) {}

  void add(const SeenBlock& block) {
    octomap::OcTreeNode* node = node_of(block.key);
    if (is_uniform(block.known, block.occupied, ~std::uint64_t{0})) {
      return set(*node, (block.occupied & 1) != 0);
    }
    for (unsigned octant = 0; octant < 8; ++octant) {
      const std::uint64_t known = block.known >> (8 * octant) & 0xff;
      if (known == 0) continue;
      add_octant(known, block.occupied >> (8 * octant) & 0xff,
                 *tree_.createNodeChild(node, octant));
    }
  }

 private:
  static bool is_uniform(std::uint64_t known, std::uint64_t occupied, std::uint64_t all) {
    return known == all && (occupied == 0 || occupied == all);
  }

  void set(octomap::OcTreeNode& node, bool is_occupied) const {
    node.setLogOdds(is_occupied ? tree_.getClampingThresMaxLog() : tree_.getClampingThresMinLog());
  }

  void add_octant(std::uint64_t known, std::uint64_t occupied, octomap::OcTreeNode& node) {
    if (is_uniform(known, occupied, 0xff)) return set(node, occupied != 0);
    for (unsigned voxel = 0; voxel < 8; ++voxel) {
      if ((known >> voxel & 1) == 0) continue;
      set(*tree_.createNodeChild(&node, voxel), (occupied >> voxel & 1) != 0);
    }
  }

  octomap::OcTreeNode* node_of(const CellKey& block) {
    octomap::OcTreeNode* node = tree_.getRoot();
    for (unsigned level = depth_; level-- > 0;) {
      const auto child = static_cast<unsigned>(
          child_of_parent({block.x >> level, block.y >> level, block.z >> level}));
      node = tree_.nodeChildExists(node, child) ? tree_.getNodeChild(node, child)
                                                : tree_.createNodeChild(node, child);
    }
    return node;
  }

  octomap::OcTree& tree_;
  unsigned depth_;
};

// OctoMap's prune() ends at the first depth without anything to prune, as the deepest one is here.
void prune_below(octomap::OcTree& tree, octomap::OcTreeNode* node) {
  if (!tree.nodeHasChildren(node)) return;
  for (unsigned child = 0; child < 8; ++child) {
    if (tree.nodeChildExists(node, child)) prune_below(tree, tree.getNodeChild(node, child));
  }
  tree.pruneNode(node);
}

void build(const std::vector<SeenBlock>& blocks, RootedTree& tree) {
  TreeOfBlocks nodes(tree);
  for (const SeenBlock& block : blocks) nodes.add(block);
  prune_below(tree, tree.getRoot());
}

// As OctoMap's writeBinary does, which prints on the way: the pruned tree after the head that its
// reader asks for.
std::vector<std::byte> to_bytes(const OctomapFrame& frame, const octomap::OcTree& tree) {
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
  SIGHTLINE_ASSIGN(const std::vector<SeenBlock> blocks, see_scans(surface, options));
  if (blocks.empty()) return Error{ErrorCode::kEmptyMap, "found no returns in the scans"};
  RootedTree tree(options.voxel_m);
  build(blocks, tree);
  return to_bytes(octomap_frame(surface.frame, options.voxel_m), tree);
}

}  // namespace sightline
