#include "compiler/views/exports/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "compiler/views/exports/export_frame.h"
#include "formats/base/bytes.h"

namespace sightline {
namespace {

using Face = std::array<std::int32_t, 3>;

struct Sphere {
  std::vector<Eigen::Vector3d> vertices;  // of unit length
  std::vector<Face> faces;                // counter-clockwise from outside
};

Sphere icosahedron() {
  const double t = (1.0 + std::sqrt(5.0)) / 2.0;
  Sphere sphere;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-t, t}) {
      sphere.vertices.push_back(Eigen::Vector3d(0.0, a, b).normalized());
      sphere.vertices.push_back(Eigen::Vector3d(a, b, 0.0).normalized());
      sphere.vertices.push_back(Eigen::Vector3d(b, 0.0, a).normalized());
    }
  }
  // Faces are the triples of neighbours: vertices at the length of an edge.
  const double edge = 2.0 / std::sqrt(1.0 + t * t);
  const auto are_near = [&](std::size_t i, std::size_t j) {
    return std::abs((sphere.vertices[i] - sphere.vertices[j]).norm() - edge) < 1e-9;
  };
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = i + 1; j < 12; ++j) {
      for (std::size_t k = j + 1; k < 12; ++k) {
        if (!are_near(i, j) || !are_near(j, k) || !are_near(i, k)) continue;
        const Eigen::Vector3d& a = sphere.vertices[i];
        const bool is_outward = a.dot((sphere.vertices[j] - a).cross(sphere.vertices[k] - a)) > 0.0;
        const auto first = static_cast<std::int32_t>(i);
        const auto second = static_cast<std::int32_t>(is_outward ? j : k);
        const auto third = static_cast<std::int32_t>(is_outward ? k : j);
        sphere.faces.push_back({first, second, third});
      }
    }
  }
  return sphere;
}

// Each face becomes four, new vertices lie on the sphere.
Sphere divided(const Sphere& coarse) {
  Sphere fine{coarse.vertices, {}};
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), 0);
    if (is_new) {
      at->second = static_cast<std::int32_t>(fine.vertices.size());
      const Eigen::Vector3d sum =
          fine.vertices[static_cast<std::size_t>(a)] + fine.vertices[static_cast<std::size_t>(b)];
      fine.vertices.push_back(sum.normalized());
    }
    return at->second;
  };
  for (const auto& [a, b, c] : coarse.faces) {
    const std::int32_t ab = middle(a, b);
    const std::int32_t bc = middle(b, c);
    const std::int32_t ca = middle(c, a);
    for (const Face& face : {Face{a, ab, ca}, Face{b, bc, ab}, Face{c, ca, bc}, Face{ab, bc, ca}}) {
      fine.faces.push_back(face);
    }
  }
  return fine;
}

// Told apart by those who see colours differently too.
std::array<std::uint8_t, 3> colour_of(const Nd& nd) {
  const int dimension = dimension_class(nd);
  if (dimension == 1) return {230, 159, 0};
  if (dimension == 2) return {0, 114, 178};
  return {153, 153, 153};
}

void put_vertices(const Nd& nd, const Sphere& sphere, const Eigen::Vector3d& shift_m,
                  ByteWriter& writer) {
  constexpr double kSigmas = 2.0;
  const Eigen::Vector3d radii_m = kSigmas * nd.eigenvalues_m2.cwiseSqrt();
  const std::array<std::uint8_t, 3> colour = colour_of(nd);
  for (const Eigen::Vector3d& vertex : sphere.vertices) {
    const Eigen::Vector3d p_m =
        nd.mean_m + nd.eigenvectors * radii_m.cwiseProduct(vertex) + shift_m;
    for (int axis = 0; axis < 3; ++axis) writer.put(static_cast<float>(p_m[axis]));
    for (const std::uint8_t channel : colour) writer.put(channel);
  }
}

void put_faces(const Sphere& sphere, std::size_t first_vertex, ByteWriter& writer) {
  for (const Face& face : sphere.faces) {
    writer.put(std::uint8_t{3});
    for (const std::int32_t vertex : face) {
      writer.put(static_cast<std::int32_t>(first_vertex) + vertex);
    }
  }
}

struct Voxel {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
};

}  // namespace

Result<void> write_nd_ellipsoids(const NdtMap& map, const ByteSink& sink) {
  constexpr std::size_t kNdsAtOnce = 1024;  // a mebibyte
  const Sphere sphere = divided(icosahedron());
  const std::string header = concat(
      "ply\nformat binary_little_endian 1.0\n"
      "comment NDs at two standard deviations; line orange, plane blue, volume grey\n"
      "element vertex ",
      map.nds.size() * kEllipsoidVertices,
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nelement face ",
      map.nds.size() * kEllipsoidFaces, "\nproperty list uchar int vertex_indices\nend_header\n");
  SIGHTLINE_TRY(sink(std::as_bytes(std::span(header))));
  const Eigen::Vector3d shift_m = export_shift_m(map.frame);
  // Hands over what `put` writes of each ND.
  const auto put_all = [&](const auto& put) -> Result<void> {
    for (std::size_t first = 0; first < map.nds.size(); first += kNdsAtOnce) {
      ByteWriter writer;
      const std::size_t end = std::min(first + kNdsAtOnce, map.nds.size());
      for (std::size_t i = first; i < end; ++i) put(i, writer);
      SIGHTLINE_TRY(sink(writer.bytes()));
    }
    return {};
  };
  SIGHTLINE_TRY(put_all([&](std::size_t i, ByteWriter& writer) {
    put_vertices(map.nds[i], sphere, shift_m, writer);
  }));
  return put_all([&](std::size_t i, ByteWriter& writer) {
    put_faces(sphere, i * kEllipsoidVertices, writer);
  });
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
