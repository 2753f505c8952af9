#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"

namespace sightline {

// What the sensor would see at each site: slant distance of the first hit for every cell of a level
// image in map axes. Column a covers azimuth [a, a+1) degrees counter-clockwise from +x (ray at
// a + 0.5); row e is at elevation first_elevation_deg + e * elevation_step_deg.
struct DepthImages {
  std::uint32_t azimuth_count = 360;
  std::uint32_t elevation_count = 31;
  double first_elevation_deg = -15.0;
  double elevation_step_deg = 1.0;
  double near_m = 0.5;
  double longest_range_m = 50.0;
  std::uint32_t site_count = 0;
  std::vector<float> distance_m;  // [site][elevation][azimuth]; +inf where nothing is hit, NaN
                                  // out of the sensor's view

  [[nodiscard]] std::size_t cells_per_site() const {
    return static_cast<std::size_t>(azimuth_count) * elevation_count;
  }
  [[nodiscard]] std::span<const float> image_of(std::size_t site) const {
    return std::span(distance_m).subspan(site * cells_per_site(), cells_per_site());
  }
};
SIGHTLINE_FIELDS(DepthImages, azimuth_count, elevation_count, first_elevation_deg,
                 elevation_step_deg, near_m, longest_range_m, site_count, distance_m)
SIGHTLINE_ARTIFACT(DepthImages, "depth-images", 1)

Result<void> validate(const DepthImages& images);
Table dump(const DepthImages& images);

// What the localizing sensor would measure at each site if it stood there level, without noise or
// drop-out: its beams cast on the surface, then subsampled on the localizer's voxel grid.
struct VirtualScans {
  double longest_range_m = 50.0;
  double leaf_m = 1.0;                    // edge of a voxel
  std::vector<std::uint64_t> end;         // per site: one past its last point; ascending
  std::vector<Eigen::Vector3d> points_m;  // from the site's p, map axes; by voxel key within a site

  [[nodiscard]] std::size_t site_count() const { return end.size(); }
  [[nodiscard]] std::span<const Eigen::Vector3d> points_of(std::size_t site) const {
    const std::size_t begin = site == 0 ? 0 : static_cast<std::size_t>(end[site - 1]);
    return std::span(points_m).subspan(begin, static_cast<std::size_t>(end[site]) - begin);
  }
};
SIGHTLINE_FIELDS(VirtualScans, longest_range_m, leaf_m, end, points_m)
SIGHTLINE_ARTIFACT(VirtualScans, "virtual-scans", 1)

Result<void> validate(const VirtualScans& scans);
Table dump(const VirtualScans& scans);

}  // namespace sightline
