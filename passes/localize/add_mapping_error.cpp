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

// Of one site and range, m; nothing: the stand-in.
using ErrorOf = std::function<std::optional<double>(std::size_t site, std::size_t range)>;

// Two more columns: what is known of the map's own scans, and what a model may learn of that.
Result<FactorTable> with_columns(const FactorTable& factors, const ErrorOf& own_error_m,
                                 const ErrorOf& mapping_error_m) {
  const auto found = std::ranges::find(factors.factors, kStandIn);
  if (found == factors.factors.end()) {
    return mismatched(std::string("the factors have no ") + kStandIn);
  }
  const auto stand_in = static_cast<std::size_t>(found - factors.factors.begin());
  const std::size_t before = factors.factors.size();
  FactorTable table = factors;
  table.factors.insert(table.factors.end(), {"own_error", "mapping_error"});
  table.values.clear();
  table.values.reserve(factors.values.size() / before * table.factors.size());
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t range = 0; range < factors.ranges_m.size(); ++range) {
      for (std::size_t f = 0; f < before; ++f) table.values.push_back(factors.at(site, range, f));
      const double stand_in_m = factors.at(site, range, stand_in);
      table.values.push_back(own_error_m(site, range).value_or(stand_in_m));
      table.values.push_back(mapping_error_m(site, range).value_or(stand_in_m));
    }
  }
  return table;
}

std::optional<double> unknown(std::size_t, std::size_t) { return std::nullopt; }

ErrorOf errors_of(const MeasuredError& measured) {
  return [&measured](std::size_t site, std::size_t range) -> std::optional<double> {
    if (measured.scan_of_site[site] < 0) return std::nullopt;
    return measured.row(site, range).mean_m;
  };
}

Result<void> check_measured(const FactorTable& map_factors, const MeasuredError& measured) {
  if (measured.scan_of_site.size() == map_factors.site_count &&
      measured.ranges_m == map_factors.ranges_m) {
    return {};
  }
  return mismatched("the mapping drive was localized at " +
                    std::to_string(measured.scan_of_site.size()) +
                    " sites, expected the factors' " + std::to_string(map_factors.site_count) +
                    " and their ranges");
}

}  // namespace

Result<FactorTable> add_mapping_error(PassContext& ctx, const NoOptions&,
                                      const FactorTable& map_factors, const MeasuredError& own,
                                      const MeasuredError& by_pose,
                                      const SensorProfile& mapping_sensor,
                                      const SensorProfile& localizing_sensor) {
  SIGHTLINE_TRY(check_measured(map_factors, own));
  SIGHTLINE_TRY(check_measured(map_factors, by_pose));
  if (to_bytes(mapping_sensor) != to_bytes(localizing_sensor)) {
    ctx.warn("sensor " + mapping_sensor.name + " made the map and " + localizing_sensor.name +
             " is to localize in it: mapping_error is what virtual scans tell");
    return with_columns(map_factors, unknown, unknown);
  }
  return with_columns(map_factors, errors_of(own), errors_of(by_pose));
}

Result<FactorTable> add_own_error(PassContext&, const NoOptions&, const FactorTable& map_factors,
                                  const MeasuredError& own) {
  SIGHTLINE_TRY(check_measured(map_factors, own));
  return with_columns(map_factors, errors_of(own), unknown);
}

}  // namespace sightline
