#include "formats/surroundings/site_views.h"

#include <cmath>

#include "formats/record/cells.h"

namespace sightline {

Result<void> validate(const DepthImages& images) {
  if (images.azimuth_count == 0 || images.elevation_count == 0) {
    return invalid_artifact("a depth image has no cells", "");
  }
  const bool numbers_make_sense =
      std::isfinite(images.first_elevation_deg) && images.elevation_step_deg > 0.0 &&
      images.near_m >= 0.0 && images.longest_range_m > images.near_m &&
      std::isfinite(images.elevation_step_deg) && std::isfinite(images.longest_range_m);
  if (!numbers_make_sense)
    return invalid_artifact("elevations or range limits are out of range", "");
  const std::size_t expected = images.site_count * images.cells_per_site();
  if (images.distance_m.size() != expected) {
    return invalid_artifact(
        concat("found ", images.distance_m.size(), " cells, expected ", expected), "");
  }
  for (std::size_t i = 0; i < images.distance_m.size(); ++i) {
    if (images.distance_m[i] < 0.0F) {
      return invalid_artifact("a distance is negative",
                              concat("site ", i / images.cells_per_site()));
    }
  }
  return {};
}

Table dump(const DepthImages& images) {
  Table table{"depth", {}, {}, {}};
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

Result<void> validate(const VirtualScans& scans) {
  const bool lengths_make_sense = scans.longest_range_m > 0.0 && scans.leaf_m > 0.0 &&
                                  std::isfinite(scans.longest_range_m) &&
                                  std::isfinite(scans.leaf_m);
  if (!lengths_make_sense)
    return invalid_artifact("the longest range or the leaf is not above 0 m", "");
  std::uint64_t before = 0;
  for (std::size_t site = 0; site < scans.end.size(); ++site) {
    if (scans.end[site] < before) {
      return invalid_artifact("a scan ends before it begins", concat("site ", site));
    }
    before = scans.end[site];
  }
  if (before != scans.points_m.size()) {
    return invalid_artifact(concat("found ", scans.points_m.size(), " points, expected ", before),
                            "");
  }
  for (std::size_t i = 0; i < scans.points_m.size(); ++i) {
    if (!scans.points_m[i].allFinite()) {
      return invalid_artifact("a point is not finite", concat("point ", i));
    }
  }
  return {};
}

Table dump(const VirtualScans& scans) {
  Table table{"virtual-scans", {}, {}, {}};
  append_facts(scans, table);
  table.columns = {"site", "x_m", "y_m", "z_m"};
  table.rows.reserve(scans.points_m.size());
  for (std::size_t site = 0; site < scans.site_count(); ++site) {
    for (const Eigen::Vector3d& point_m : scans.points_of(site)) {
      table.rows.push_back(
          {static_cast<std::int64_t>(site), point_m.x(), point_m.y(), point_m.z()});
    }
  }
  return table;
}

}  // namespace sightline
