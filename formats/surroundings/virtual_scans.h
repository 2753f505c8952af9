#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/artifact.h"
#include "formats/geometry.h"
#include "formats/record/fields.h"

namespace sightline {

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

template <>
struct ArtifactTraits<VirtualScans> {
  static constexpr std::string_view kName = "virtual-scans";
  static constexpr std::uint32_t kVersion = 1;
};

Result<void> validate(const VirtualScans& scans);
Table dump(const VirtualScans& scans);

}  // namespace sightline
