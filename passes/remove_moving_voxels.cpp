#include "passes/remove_moving_voxels.h"

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTreeBaseImpl.h>
#include <octomap/OcTreeDataNode.h>

#include <array>
#include <cstdlib>

namespace sightline {
namespace {

// An octree whose leaves carry a number.
using NumberNode = octomap::OcTreeDataNode<std::uint32_t>;

// OcTreeBase.h, meant to be derived from, does not compile as C++20; this is what it does.
using NumberTreeBase = octomap::OcTreeBaseImpl<NumberNode, octomap::AbstractOcTree>;

class NumberTree : public NumberTreeBase {
 public:
  NumberTree() : NumberTreeBase(1.0) {}
  [[nodiscard]] NumberTree* create() const override { return new NumberTree; }
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
  CellKey centre;
  std::uint32_t count = 0;

  // Whether the octree can hold the voxel, and its key there.
  [[nodiscard]] bool key_of(const CellKey& key, octomap::OcTreeKey& found) const {
    constexpr std::int64_t kReach = 32767;
    const std::array<std::int64_t, 3> offset = {std::int64_t{key.x} - centre.x,
                                                std::int64_t{key.y} - centre.y,
                                                std::int64_t{key.z} - centre.z};
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (std::abs(offset[axis]) > kReach) return false;
      found[axis] = static_cast<octomap::key_type>(offset[axis] + kReach + 1);
    }
    return true;
  }
};

VoxelIndex::VoxelIndex(const CellKey& centre) : tree_(std::make_unique<Tree>()) {
  tree_->centre = centre;
}
VoxelIndex::~VoxelIndex() = default;
VoxelIndex::VoxelIndex(VoxelIndex&&) noexcept = default;
VoxelIndex& VoxelIndex::operator=(VoxelIndex&&) noexcept = default;

std::uint32_t VoxelIndex::insert(const CellKey& key) {
  octomap::OcTreeKey found;
  if (!tree_->key_of(key, found)) return kNone;
  bool is_new = false;
  const NumberNode* node = tree_->octree.leaf(found, tree_->count, is_new);
  if (is_new) ++tree_->count;
  return node->getValue();
}

std::uint32_t VoxelIndex::find(const CellKey& key) const {
  octomap::OcTreeKey found;
  if (!tree_->key_of(key, found)) return kNone;
  const NumberNode* node = tree_->octree.search(found);
  return node == nullptr ? kNone : node->getValue();
}

std::size_t VoxelIndex::size() const { return tree_->count; }

}  // namespace sightline
