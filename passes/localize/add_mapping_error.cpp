#include "passes/localize/add_mapping_error.h"

#include <algorithm>
#include <functional>
#include <optional>

namespace sightline {
namespace {

constexpr const char* kStandIn = "virtual_error";

Error mismatched(std::string message) {
  return {ErrorCode::kMismatchedInputs, std::move(message), "", "pass add-mapping-error"};
}

// One more column: what `error_m(site, range)` knows, else the stand-in.
Result<FactorTable> with_column(
    const FactorTable& factors,
    const std::function<std::optional<double>(std::size_t, std::size_t)>& error_m) {
  const auto found = std::ranges::find(factors.factors, kStandIn);
  if (found == factors.factors.end()) {
    return mismatched(std::string("the factors have no ") + kStandIn);
  }
  const auto stand_in = static_cast<std::size_t>(found - factors.factors.begin());
  const std::size_t before = factors.factors.size();
  FactorTable table = factors;
  table.factors.emplace_back("mapping_error");
  table.values.clear();
  table.values.reserve(factors.values.size() / before * table.factors.size());
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t range = 0; range < factors.ranges_m.size(); ++range) {
      for (std::size_t f = 0; f < before; ++f) table.values.push_back(factors.at(site, range, f));
      table.values.push_back(error_m(site, range).value_or(factors.at(site, range, stand_in)));
    }
  }
  return table;
}

}  // namespace

Result<FactorTable> add_mapping_error(PassContext& ctx, const NoOptions& options,
                                      const FactorTable& map_factors, const MeasuredError& measured,
                                      const SensorProfile& mapping_sensor,
                                      const SensorProfile& localizing_sensor) {
  if (measured.scan_of_site.size() != map_factors.site_count ||
      measured.ranges_m != map_factors.ranges_m) {
    return mismatched("the mapping drive was localized at " +
                      std::to_string(measured.scan_of_site.size()) +
                      " sites, expected the factors' " + std::to_string(map_factors.site_count) +
                      " and their ranges");
  }
  if (to_bytes(mapping_sensor) != to_bytes(localizing_sensor)) {
    ctx.warn("sensor " + mapping_sensor.name + " made the map and " + localizing_sensor.name +
             " is to localize in it: mapping_error is what virtual scans tell");
    return add_no_mapping_error(ctx, options, map_factors);
  }
  return with_column(map_factors,
                     [&](std::size_t site, std::size_t range) -> std::optional<double> {
                       if (measured.scan_of_site[site] < 0) return std::nullopt;
                       return measured.row(site, range).mean_m;
                     });
}

Result<FactorTable> add_no_mapping_error(PassContext&, const NoOptions&,
                                         const FactorTable& map_factors) {
  return with_column(map_factors, [](std::size_t, std::size_t) { return std::nullopt; });
}

}  // namespace sightline
