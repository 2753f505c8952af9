#include "formats/surroundings/virtual_scans.h"

#include <cmath>

#include "formats/record/cells.h"

namespace sightline {
namespace {

Error invalid(std::string message, std::string place) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "", std::move(place)};
}

}  // namespace

Result<void> validate(const VirtualScans& scans) {
  const bool lengths_make_sense = scans.longest_range_m > 0.0 && scans.leaf_m > 0.0 &&
                                  std::isfinite(scans.longest_range_m) &&
                                  std::isfinite(scans.leaf_m);
  if (!lengths_make_sense) return invalid("longest range or leaf make no sense", "");
  std::uint64_t before = 0;
  for (std::size_t site = 0; site < scans.end.size(); ++site) {
    if (scans.end[site] < before) {
      return invalid("a scan ends before it begins", "site " + std::to_string(site));
    }
    before = scans.end[site];
  }
  if (before != scans.points_m.size()) {
    return invalid("found " + std::to_string(scans.points_m.size()) + " points, expected " +
                       std::to_string(before),
                   "");
  }
  for (std::size_t i = 0; i < scans.points_m.size(); ++i) {
    if (!scans.points_m[i].allFinite()) {
      return invalid("a point is not finite", "point " + std::to_string(i));
    }
  }
  return {};
}

Table dump(const VirtualScans& scans) {
  Table table;
  table.name = "virtual-scans";
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
