#include "passes/remove_moving_voxels.h"

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTreeBaseImpl.h>
#include <octomap/OcTreeDataNode.h>

#include <cmath>

namespace sightline {
namespace {

// An octree whose leaves carry a number.
using NumberNode = octomap::OcTreeDataNode<std::uint32_t>;

// OcTreeBase.h, meant to be derived from, does not compile as C++20; this is what it does.
using NumberTreeBase = octomap::OcTreeBaseImpl<NumberNode, octomap::AbstractOcTree>;

class NumberTree : public NumberTreeBase {
 public:
  explicit NumberTree(double voxel_m) : NumberTreeBase(voxel_m) {}
  [[nodiscard]] NumberTree* create() const override { return new NumberTree(resolution); }
  [[nodiscard]] std::string getTreeType() const override { return "NumberTree"; }

  // The leaf at `key`, made with `number` where there is none.
  NumberNode* leaf(const octomap::OcTreeKey& key, std::uint32_t number, bool& is_new) {
    is_new = false;
    if (root == nullptr) {
      root = new NumberNode(VoxelIndex::kNone);
      ++tree_size;
    }
    NumberNode* node = root;
    for (unsigned level = tree_depth; level-- > 0;) {
      const unsigned child = octomap::computeChildIdx(key, static_cast<int>(level));
      if (!nodeChildExists(node, child)) {
        createNodeChild(node, child)->setValue(level == 0 ? number : VoxelIndex::kNone);
        is_new = level == 0;
      }
      node = getNodeChild(node, child);
    }
    return node;
  }
};

}  // namespace

struct VoxelIndex::Tree {
  NumberTree octree;
  Eigen::Vector3d centre_m;  // a multiple of the voxel's edge
  std::uint32_t count = 0;

  Tree(double voxel_m, const Eigen::Vector3d& near_m) : octree(voxel_m) {
    for (int axis = 0; axis < 3; ++axis) {
      centre_m[axis] = std::floor(near_m[axis] / voxel_m) * voxel_m;
    }
  }
  [[nodiscard]] octomap::point3d local(const Eigen::Vector3d& point_m) const {
    const Eigen::Vector3f offset = (point_m - centre_m).cast<float>();
    return {offset.x(), offset.y(), offset.z()};
  }
};

VoxelIndex::VoxelIndex(double voxel_m, const Eigen::Vector3d& centre_m)
    : tree_(std::make_unique<Tree>(voxel_m, centre_m)) {}
VoxelIndex::~VoxelIndex() = default;
VoxelIndex::VoxelIndex(VoxelIndex&&) noexcept = default;
VoxelIndex& VoxelIndex::operator=(VoxelIndex&&) noexcept = default;

std::uint32_t VoxelIndex::insert(const Eigen::Vector3d& point_m) {
  octomap::OcTreeKey key;
  if (!tree_->octree.coordToKeyChecked(tree_->local(point_m), key)) return kNone;
  bool is_new = false;
  const NumberNode* node = tree_->octree.leaf(key, tree_->count, is_new);
  if (is_new) ++tree_->count;
  return node->getValue();
}

std::uint32_t VoxelIndex::find(const Eigen::Vector3d& point_m) const {
  octomap::OcTreeKey key;
  if (!tree_->octree.coordToKeyChecked(tree_->local(point_m), key)) return kNone;
  const NumberNode* node = tree_->octree.search(key);
  return node == nullptr ? kNone : node->getValue();
}

std::size_t VoxelIndex::size() const { return tree_->count; }

struct RayWalk::Scratch {
  const VoxelIndex::Tree& tree;
  octomap::KeyRay keys;
  std::vector<std::uint32_t> found;
};

RayWalk::RayWalk(const VoxelIndex& voxels)
    : scratch_(std::make_unique<Scratch>(Scratch{*voxels.tree_, {}, {}})) {}
RayWalk::~RayWalk() = default;
RayWalk::RayWalk(RayWalk&&) noexcept = default;
RayWalk& RayWalk::operator=(RayWalk&&) noexcept = default;

const std::vector<std::uint32_t>& RayWalk::along(const Eigen::Vector3d& from_m,
                                                 const Eigen::Vector3d& to_m) {
  const VoxelIndex::Tree& tree = scratch_->tree;
  scratch_->found.clear();
  if (!tree.octree.computeRayKeys(tree.local(from_m), tree.local(to_m), scratch_->keys)) {
    return scratch_->found;
  }
  for (const octomap::OcTreeKey& key : scratch_->keys) {
    const NumberNode* node = tree.octree.search(key);
    if (node != nullptr) scratch_->found.push_back(node->getValue());
  }
  return scratch_->found;
}

}  // namespace sightline
