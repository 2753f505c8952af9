#include "formats/surroundings/depth_images.h"

#include <cmath>

namespace sightline {

Result<void> validate(const DepthImages& images) {
  if (images.azimuth_count == 0 || images.elevation_count == 0) {
    return invalid_artifact("a depth image has no cells", "");
  }
  const bool numbers_make_sense =
      std::isfinite(images.first_elevation_deg) && images.elevation_step_deg > 0.0 &&
      images.near_m >= 0.0 && images.longest_range_m > images.near_m &&
      std::isfinite(images.elevation_step_deg) && std::isfinite(images.longest_range_m);
  if (!numbers_make_sense) return invalid_artifact("elevations or range limits make no sense", "");
  const std::size_t expected = images.site_count * images.cells_per_site();
  if (images.distance_m.size() != expected) {
    return invalid_artifact("found " + std::to_string(images.distance_m.size()) +
                                " cells, expected " + std::to_string(expected),
                            "");
  }
  for (std::size_t i = 0; i < images.distance_m.size(); ++i) {
    if (images.distance_m[i] < 0.0F) {
      return invalid_artifact("a distance is negative",
                              "site " + std::to_string(i / images.cells_per_site()));
    }
  }
  return {};
}

Table dump(const DepthImages& images) {
  Table table;
  table.name = "depth";
  table.facts = {{"near_m", images.near_m}, {"longest_range_m", images.longest_range_m}};
  table.columns = {"site", "elevation_deg", "azimuth_deg", "distance_m"};
  table.rows.reserve(images.distance_m.size());
  std::size_t cell = 0;
  for (std::uint32_t site = 0; site < images.site_count; ++site) {
    for (std::uint32_t row = 0; row < images.elevation_count; ++row) {
      const double elevation_deg = images.first_elevation_deg + row * images.elevation_step_deg;
      for (std::uint32_t column = 0; column < images.azimuth_count; ++column) {
        const double azimuth_deg = (column + 0.5) * 360.0 / images.azimuth_count;
        table.rows.push_back({std::int64_t{site}, elevation_deg, azimuth_deg,
                              static_cast<double>(images.distance_m[cell++])});
      }
    }
  }
  return table;
}

}  // namespace sightline
