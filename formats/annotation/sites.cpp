#include "formats/annotation/sites.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

Error invalid_site(std::size_t site, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("site ", site)};
}

Result<void> validate_order(const Sites& sites, std::size_t i) {
  const Site& site = sites.sites[i];
  const bool starts_run = i == 0 || site.run != sites.sites[i - 1].run;
  if (starts_run) {
    const std::uint32_t expected = i == 0 ? 0 : sites.sites[i - 1].run + 1;
    if (site.run != expected || site.s_m != 0.0) {
      return invalid_site(i,
                          concat("found run ", site.run, " starting at ", format_double(site.s_m),
                                 " m, expected run ", expected, " at 0 m"));
    }
    return {};
  }
  if (!(site.s_m > sites.sites[i - 1].s_m) || !std::isfinite(site.s_m)) {
    return invalid_site(
        i, concat("found ", format_double(site.s_m), " m after ",
                  format_double(sites.sites[i - 1].s_m), " m, expected ascending ones"));
  }
  return {};
}

}  // namespace

double route_length_m(const Sites& sites) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < sites.sites.size(); ++i) {
    if (sites.sites[i].run == sites.sites[i - 1].run) {
      length_m += sites.sites[i].s_m - sites.sites[i - 1].s_m;
    }
  }
  return length_m;
}

std::vector<Eigen::Vector3d> positions_m(const Sites& sites) {
  std::vector<Eigen::Vector3d> found_m;
  for (const Site& site : sites.sites) found_m.push_back(site.p_map_m);
  return found_m;
}

double off_road_deg(const Site& site, double heading_deg) {
  const Eigen::Vector3d ahead = site.T_map_vehicle.linear().col(0);
  const double road_deg = portable_atan2(ahead.y(), ahead.x()) * 180.0 / std::numbers::pi;
  const double turned_deg = std::fmod(std::abs(heading_deg - road_deg), 180.0);
  return std::min(turned_deg, 180.0 - turned_deg);
}

std::string_view name_of_way(double off_road_deg) {
  if (off_road_deg < 30.0) return "along the road";
  return off_road_deg > 60.0 ? "across the road" : "aslant";
}

Result<void> validate(const Sites& sites) {
  if (!sites.frame.origin_world_m.allFinite() || !std::isfinite(sites.spacing_m) ||
      sites.spacing_m <= 0.0) {
    return Error{ErrorCode::kInvalidArtifact,
                 "the sites' origin is not finite, or their spacing is not above 0 m"};
  }
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    SIGHTLINE_TRY(validate_order(sites, i));
    if (!is_rigid(sites.sites[i].T_map_vehicle)) {
      return invalid_site(i, "found a pose that is not a rigid motion");
    }
    if (!sites.sites[i].p_map_m.allFinite()) {
      return invalid_site(i, "found a sensor origin that is not finite");
    }
  }
  return {};
}

Table dump(const Sites& sites) {
  Table table;
  table.name = "sites";
  append_facts(sites.frame, table);
  table.facts.emplace_back("spacing_m", sites.spacing_m);
  table.columns = {"site", "run", "s_m", "p_x_m", "p_y_m", "p_z_m"};
  append_pose_columns(table.columns);
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Site& site = sites.sites[i];
    std::vector<Cell> row = {static_cast<std::int64_t>(i), std::int64_t{site.run}, site.s_m};
    for (int axis = 0; axis < 3; ++axis) row.emplace_back(site.p_map_m[axis]);
    append_cells(site.T_map_vehicle, row);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace sightline
