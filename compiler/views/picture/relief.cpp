#include "compiler/views/picture/relief.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

namespace sightline {
namespace {

// Sites nearer to each other than this tell the same height.
constexpr double kSpotCell_m = 8.0;

std::uint8_t value_of(double height_m) {
  const double steps = (height_m - kReliefLowest_m) / kReliefStep_m;
  return static_cast<std::uint8_t>(1 + std::clamp(std::lround(steps), 0L, 254L));
}

// A patch as a lattice of points, near enough to each other to leave no pixel out.
void draw_patch(const SurfacePatch& patch, double road_m, const MapBox& box, double pixel_m,
                GreyRaster& raster) {
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * patch.half_side_m / pixel_m)));
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const double u_m = patch.half_side_m * (2.0 * i / steps - 1.0);
      const double v_m = patch.half_side_m * (2.0 * j / steps - 1.0);
      const Eigen::Vector3d at_m = patch.centre_m + u_m * along + v_m * across;
      const double column = std::floor((at_m.x() - box.low_x_m) / pixel_m);
      const double row = std::floor((box.high_y_m - at_m.y()) / pixel_m);
      if (column < 0.0 || row < 0.0 || column >= raster.width || row >= raster.height) continue;
      std::uint8_t& pixel =
          raster.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
      pixel = std::max(pixel, value_of(at_m.z() - road_m));
    }
  }
}

}  // namespace

RoadHeight::RoadHeight(const Sites& sites, double sensor_height_m) {
  std::set<TileKey> taken;
  std::vector<Eigen::Vector3d> places_m;
  for (const Site& site : sites.sites) {
    const Eigen::Vector3d& p_m = site.p_map_m;
    if (!taken.insert(tile_key(p_m, kSpotCell_m)).second) continue;
    places_m.emplace_back(p_m.x(), p_m.y(), 0.0);
    heights_m_.push_back(p_m.z() - sensor_height_m);
  }
  places_ = PointGrid(places_m, kSpotCell_m);
}

double RoadHeight::at(double x_m, double y_m) const {
  const std::optional<NearPoint> nearest =
      places_.nearest({x_m, y_m, 0.0}, std::numeric_limits<double>::infinity());
  return nearest ? heights_m_[nearest->index] : 0.0;
}

GreyRaster relief_picture(const Surface& surface, const std::vector<std::size_t>& patches,
                          const RoadHeight& road, const MapBox& box, double pixel_m) {
  const auto pixels = [&](double length_m) {
    return static_cast<std::uint32_t>(std::max(1.0, std::ceil(length_m / pixel_m - 1e-9)));
  };
  GreyRaster raster(pixels(box.high_x_m - box.low_x_m), pixels(box.high_y_m - box.low_y_m));
  for (const std::size_t i : patches) {
    const SurfacePatch& patch = surface.patches[i];
    draw_patch(patch, road.at(patch.centre_m.x(), patch.centre_m.y()), box, pixel_m, raster);
  }
  return raster;
}

}  // namespace sightline
