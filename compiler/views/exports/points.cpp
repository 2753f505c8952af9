#include "compiler/views/exports/points.h"

#include <map>
#include <string>

#include "formats/base/bytes.h"

namespace sightline {
namespace {

struct Voxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
};

}  // namespace

Result<std::vector<Eigen::Vector3d>> thinned_points(const SurfacePoints& surface, double leaf_m) {
  if (leaf_m < 0.0) {
    return Error{ErrorCode::kBadValue, "a leaf must be 0 m or more"};
  }
  std::vector<Eigen::Vector3d> points_m;
  std::map<CellKey, Voxel> voxels;
  const SurfacePointReader reader(surface);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> standing, reader.standing(part));
    if (leaf_m == 0.0) points_m.insert(points_m.end(), standing.begin(), standing.end());
    if (leaf_m == 0.0) continue;
    for (const Eigen::Vector3d& p_m : standing) {
      Voxel& voxel = voxels[cell_key(p_m, leaf_m)];
      voxel.sum_m += p_m;
      voxel.count += 1.0;
    }
  }
  for (const auto& [key, voxel] : voxels) points_m.push_back(voxel.sum_m / voxel.count);
  return points_m;
}

std::vector<std::byte> points_ply(const std::vector<Eigen::Vector3d>& points_m) {
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                             std::to_string(points_m.size()) +
                             "\nproperty double x\nproperty double y\nproperty double z\n"
                             "end_header\n";
  ByteWriter writer;
  writer.append(header.data(), header.size());
  for (const Eigen::Vector3d& p_m : points_m) {
    for (int axis = 0; axis < 3; ++axis) writer.put(p_m[axis]);
  }
  return writer.take();
}

}  // namespace sightline
