#include "compiler/views/exports/ply.h"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>

#include "compiler/views/exports/export_frame.h"
#include "formats/base/bytes.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Colours that people with colour blindness distinguish.
std::array<std::uint8_t, 3> colour_of(const Nd& nd) {
  const int dimension = dimension_class(nd);
  if (dimension == 1) return {230, 159, 0};
  if (dimension == 2) return {0, 114, 178};
  return {153, 153, 153};
}

// sigmas as logarithms, colours as the first coefficient of spherical harmonics, opacity as the
// logarithm of its odds: as Kerbl et al. 2023, "3D Gaussian splatting for real-time radiance field
// rendering", write them.
constexpr float kOpacityLogit = 1.3862944F;  // 0.8
float harmonic_of(std::uint8_t channel) {
  constexpr double kZeroth = 0.28209479177387814;  // 1 / (2 sqrt(pi))
  return static_cast<float>((channel / 255.0 - 0.5) / kZeroth);
}

// A rotation onto the axes; eigenvectors may be mirrored.
Eigen::Quaterniond rotation_of(const Nd& nd) {
  Eigen::Matrix3d axes = nd.eigenvectors;
  if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
  return Eigen::Quaterniond(axes).normalized();
}

void put_gaussian(const Nd& nd, const Eigen::Vector3d& shift_m, ByteWriter& writer) {
  const Eigen::Vector3d p_m = nd.mean_m + shift_m;
  for (int axis = 0; axis < 3; ++axis) writer.put(static_cast<float>(p_m[axis]));
  for (int axis = 0; axis < 3; ++axis) {
    writer.put(static_cast<float>(0.5 * portable_log(nd.eigenvalues_m2[axis])));
  }
  const Eigen::Quaterniond rotation = rotation_of(nd);
  for (const double part : {rotation.w(), rotation.x(), rotation.y(), rotation.z()}) {
    writer.put(static_cast<float>(part));
  }
  const std::array<std::uint8_t, 3> colour = colour_of(nd);
  for (const std::uint8_t channel : colour) writer.put(harmonic_of(channel));
  writer.put(kOpacityLogit);
  for (const std::uint8_t channel : colour) writer.put(channel);
}

struct Voxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
};

}  // namespace

Result<void> write_nd_gaussians(const NdtMap& map, const ByteSink& sink) {
  constexpr std::size_t kNdsAtOnce = 16384;  // a mebibyte
  std::string header = concat(
      "ply\nformat binary_little_endian 1.0\n"
      "comment NDs as Gaussians; line orange, plane blue, volume grey\nelement vertex ",
      map.nds.size(), "\n");
  for (const char* name : {"x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                           "rot_2", "rot_3", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"}) {
    header += concat("property float ", name, "\n");
  }
  header +=
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "end_header\n";
  SIGHTLINE_TRY(sink(std::as_bytes(std::span(header))));
  const Eigen::Vector3d shift_m = export_shift_m(map.frame);
  for (std::size_t first = 0; first < map.nds.size(); first += kNdsAtOnce) {
    ByteWriter writer;
    const std::size_t end = std::min(first + kNdsAtOnce, map.nds.size());
    for (std::size_t i = first; i < end; ++i) put_gaussian(map.nds[i], shift_m, writer);
    SIGHTLINE_TRY(sink(writer.bytes()));
  }
  return {};
}

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
  const std::string header =
      concat("ply\nformat binary_little_endian 1.0\nelement vertex ", points_m.size(),
             "\nproperty double x\nproperty double y\nproperty double z\nend_header\n");
  ByteWriter writer;
  writer.append(header.data(), header.size());
  for (const Eigen::Vector3d& p_m : points_m) {
    for (int axis = 0; axis < 3; ++axis) writer.put(p_m[axis]);
  }
  return writer.take();
}

}  // namespace sightline
