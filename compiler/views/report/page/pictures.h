#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/views/picture/ndt_picture.h"
#include "compiler/views/picture/raster.h"
#include "compiler/views/report/page/packed.h"
#include "formats/annotation/sites.h"
#include "formats/grid/point_grid.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

// What stands where, seen from above, in steps of a byte: 0 nothing; 1 to 255 the height of the
// highest patch over the road, from kReliefLowest_m in steps of kReliefStep_m, cut off at both
// ends.
inline constexpr double kReliefLowest_m = -2.0;
inline constexpr double kReliefStep_m = 0.05;

inline double relief_height_m(std::uint8_t value) {
  return kReliefLowest_m + kReliefStep_m * (value - 1);
}

// A height of the road near each place: that of the nearest site, less the sensor's height. Of two
// sites equally near, the earlier one.
class RoadHeight {
 public:
  RoadHeight(const Sites& sites, double sensor_height_m);
  // 0 where there are no sites.
  [[nodiscard]] double at(double x_m, double y_m) const;

 private:
  // One for each cell of a coarse grid that has a site.
  PointGrid places_;
  std::vector<double> heights_m_;
};

// The box in pixels of pixel_m, north up. `patches` are indices into the surface's.
GreyRaster relief_picture(const Surface& surface, const std::vector<std::size_t>& patches,
                          const RoadHeight& road, const MapBox& box, double pixel_m);

// The whole map from above in one picture of greys.
struct Overview {
  MapBox box;
  double pixel_m = 0.0;
  std::string png_base64;
};

// None where there is no surface.
std::optional<Overview> relief_overview(const Surface& surface, const Sites& sites,
                                        double sensor_height_m);

// Members of page_data.md.
PageJson relief_json(const Surface& surface, const Sites& sites, double sensor_height_m);
PageJson moved_json(const SurfacePoints& points, double tile_m);
PageJson depth_json(const DepthImages& images, double site_spacing_m);

}  // namespace sightline
