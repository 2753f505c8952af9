#include "formats/surface_points.h"

#include <cmath>

namespace sightline {
namespace {

constexpr std::size_t kBytesPerPoint = 3 * sizeof(double);
static_assert(sizeof(Eigen::Vector3d) == kBytesPerPoint);

Result<void> validate_points(const std::vector<Eigen::Vector3d>& points_m, const char* list) {
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!points_m[i].allFinite()) {
      return Error{ErrorCode::kInvalidArtifact, "found a point that is not finite", "",
                   std::string(list) + " point " + std::to_string(i)};
    }
  }
  return {};
}

void append_rows(const std::vector<Eigen::Vector3d>& points_m, bool is_moving, Table& table) {
  for (const Eigen::Vector3d& point : points_m) {
    table.rows.push_back({point.x(), point.y(), point.z(), std::int64_t{is_moving ? 1 : 0}});
  }
}

void encode_points(const std::vector<Eigen::Vector3d>& points_m, ByteWriter& writer) {
  writer.put<std::uint64_t>(points_m.size());
  writer.append(points_m.data(), points_m.size() * kBytesPerPoint);
}

void decode_points(ByteReader& reader, std::vector<Eigen::Vector3d>& points_m) {
  points_m.resize(reader.get_count(kBytesPerPoint));
  for (Eigen::Vector3d& point : points_m) {
    for (int axis = 0; axis < 3; ++axis) reader.get(point[axis]);
  }
}

}  // namespace

Result<void> validate(const SurfacePoints& points) {
  if (!points.frame.origin_world_m.allFinite() || !std::isfinite(points.voxel_m) ||
      points.voxel_m < 0.0) {
    return Error{ErrorCode::kInvalidArtifact,
                 "the surface points' origin or voxel size makes no sense", "", ""};
  }
  const Result<void> standing = validate_points(points.points_m, "standing");
  if (!standing) return standing;
  return validate_points(points.moving_m, "moving");
}

Table dump(const SurfacePoints& points) {
  Table table;
  table.name = "surface-points";
  append_facts(points.frame, table);
  table.facts.emplace_back("point_count", static_cast<std::int64_t>(points.points_m.size()));
  table.facts.emplace_back("moving_count", static_cast<std::int64_t>(points.moving_m.size()));
  table.facts.emplace_back("out_of_range_count",
                           static_cast<std::int64_t>(points.out_of_range_count));
  table.facts.emplace_back("voxel_m", points.voxel_m);
  table.columns = {"x_m", "y_m", "z_m", "is_moving"};
  append_rows(points.points_m, false, table);
  append_rows(points.moving_m, true, table);
  return table;
}

void encode(const SurfacePoints& points, ByteWriter& writer) {
  encode(points.frame, writer);
  writer.put(points.out_of_range_count);
  writer.put(points.voxel_m);
  encode_points(points.points_m, writer);
  encode_points(points.moving_m, writer);
}

void decode(ByteReader& reader, SurfacePoints& points) {
  decode(reader, points.frame);
  reader.get(points.out_of_range_count);
  reader.get(points.voxel_m);
  decode_points(reader, points.points_m);
  decode_points(reader, points.moving_m);
}

}  // namespace sightline
