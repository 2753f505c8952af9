#include "compiler/views/picture/points_picture.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

constexpr double kFinest_m = 0.2;
constexpr double kMost_pixels = 4000.0;
constexpr Colour kPaper{255, 255, 255};
constexpr Colour kRemoved{214, 39, 40};
// Greys from one point to this many.
constexpr double kDarkest_points = 300.0;

using Box = Eigen::AlignedBox2d;

struct Canvas {
  Box box;
  double pixel_m = kFinest_m;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint32_t> standing;
  std::vector<bool> is_removed;

  [[nodiscard]] std::size_t pixel_of(const Eigen::Vector3d& point_m) const {
    const Eigen::Vector2d at = (point_m.head<2>() - box.min()) / pixel_m;
    const auto column = std::min(static_cast<std::uint32_t>(at.x()), width - 1);
    const auto row = std::min(static_cast<std::uint32_t>(at.y()), height - 1);
    return static_cast<std::size_t>(height - 1 - row) * width + column;
  }
};

Result<Box> box_of(const SurfacePointReader& reader) {
  Box box;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> points_m, reader.standing(part));
    for (const Eigen::Vector3d& point_m : points_m) box.extend(point_m.head<2>());
  }
  if (!box.isEmpty()) return box;
  return Error{ErrorCode::kBadArgument, "there are no points to draw"};
}

Canvas canvas_for(const Box& box) {
  Canvas canvas;
  canvas.box = box;
  canvas.pixel_m = std::max(kFinest_m, box.sizes().maxCoeff() / kMost_pixels);
  canvas.width = static_cast<std::uint32_t>(box.sizes().x() / canvas.pixel_m) + 1;
  canvas.height = static_cast<std::uint32_t>(box.sizes().y() / canvas.pixel_m) + 1;
  canvas.standing.assign(static_cast<std::size_t>(canvas.width) * canvas.height, 0);
  canvas.is_removed.assign(canvas.standing.size(), false);
  return canvas;
}

Colour grey_of(std::uint32_t count) {
  const double share = std::min(1.0, std::log1p(count) / std::log1p(kDarkest_points));
  const auto level = static_cast<std::uint8_t>(std::lround(225.0 - 150.0 * share));
  return {level, level, level};
}

}  // namespace

Result<Raster> points_picture(const SurfacePoints& points) {
  const SurfacePointReader reader(points);
  SIGHTLINE_ASSIGN(const Box box, box_of(reader));
  Canvas canvas = canvas_for(box);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> points_m, reader.standing(part));
    for (const Eigen::Vector3d& point_m : points_m) ++canvas.standing[canvas.pixel_of(point_m)];
  }
  for (const CellKey& key : points.moved_voxels) {
    const Eigen::Vector3d centre_m = cell_centre_m(key, points.voxel_m);
    if (box.contains(centre_m.head<2>())) canvas.is_removed[canvas.pixel_of(centre_m)] = true;
  }
  Raster raster(canvas.width, canvas.height, kPaper);
  for (std::size_t i = 0; i < raster.pixels.size(); ++i) {
    if (canvas.standing[i] > 0) raster.pixels[i] = grey_of(canvas.standing[i]);
    if (canvas.is_removed[i]) raster.pixels[i] = kRemoved;
  }
  return raster;
}

}  // namespace sightline
