#include "formats/reader/site_protection.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sightline {
namespace {

constexpr std::string_view kKindColumn = "place_kind";

unsigned kind_number(const MapColumn& kinds, std::uint32_t site) {
  if (site >= kinds.values.size()) return 0;
  const float number = kinds.values[site];
  return number >= 0.0F && number < 256.0F ? static_cast<unsigned>(number) : 0;
}

}  // namespace

SiteProtection site_protection(std::uint32_t place_kind, const PoseErrors& own, double risk) {
  SiteProtection result;
  result.place_kind = place_kind;
  const ProtectionRow& row = protection_row(group_of_kind(place_kind));
  result.block_count = row.block_count;
  const ProtectionFactors factors = protection_factors(row, risk);
  if (!std::isfinite(factors[0])) return result;
  result.levels = row.percent_errors;
  const double measured[] = {own.longitudinal_m, own.lateral_m, 0.0, own.yaw_rad};
  for (std::size_t i = 0; i < kProtectionAxes; ++i) {
    if (!std::isfinite(measured[i])) continue;
    result.levels[i] = std::max(result.levels[i], factors[i] * measured[i]);
  }
  return result;
}

MapProtection::MapProtection(MapColumn kinds, MapErrors errors)
    : kinds_(std::move(kinds)), errors_(errors) {}

SiteProtection MapProtection::at(std::uint32_t site, double risk, bool is_sample) const {
  const PoseErrors own = is_sample ? errors_.of_sample(site) : errors_.of_range(site);
  return site_protection(kind_number(kinds_, site), own, risk);
}

Result<MapProtection> protection_of(const MapReader& map) {
  MapColumn kinds;
  if (std::ranges::find(map.info().columns, kKindColumn) != map.info().columns.end()) {
    SIGHTLINE_ASSIGN(kinds, map.column(kKindColumn));
  }
  SIGHTLINE_ASSIGN(const MapErrors errors, map.errors());
  return MapProtection(std::move(kinds), errors);
}

}  // namespace sightline
