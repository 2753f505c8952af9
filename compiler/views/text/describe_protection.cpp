#include "compiler/views/text/describe_protection.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "formats/model/place_kind.h"

namespace sightline {
namespace {

// Infinite where the map has no such column.
double value_at(const CompiledMap& map, std::string_view name, std::size_t site) {
  const auto column = std::ranges::find(map.columns, name, &SiteColumn::name);
  return column == map.columns.end() ? kUnavailable : double{column->values[site]};
}

}  // namespace

SiteProtection protection_at(const CompiledMap& map, std::size_t site) {
  const PoseErrors own = {
      value_at(map, kTrackingRangeColumns[0], site), value_at(map, kTrackingRangeColumns[1], site),
      value_at(map, kTrackingRangeColumns[2], site), value_at(map, kTrackingRangeColumns[3], site)};
  const auto kind = static_cast<std::uint32_t>(kind_at(map.columns, site));
  return site_protection(kind, own, kShownRisk);
}

std::string describe_protection(const CompiledMap& map, std::size_t site) {
  const SiteProtection found = protection_at(map, site);
  const auto& [forward_m, left_m, up_m, yaw_rad] = found.levels;
  return fmt::format(
      "  protection level, while tracking, risk {:g} % in 60 m: forward {:.2f}, left {:.2f}, up "
      "{:.2f} m, yaw {:.2f} degrees (from {} blocks of generated worlds)\n",
      100.0 * kShownRisk, forward_m, left_m, up_m, yaw_rad * 180.0 / std::numbers::pi,
      found.block_count);
}

}  // namespace sightline
