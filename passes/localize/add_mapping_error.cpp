#include "passes/localize/add_mapping_error.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/tables/stored_table_writer.h"

namespace sightline {
namespace {

constexpr const char* kStandIn = "virtual_error";

Error mismatched(std::string message) {
  return {ErrorCode::kMismatchedInputs, std::move(message), "", "pass add-mapping-error"};
}

// Of one site and look, m; nothing: the stand-in.
using ErrorOf = std::function<std::optional<double>(std::size_t site, std::size_t look)>;

// What is known of the map's own scans, and what a model may learn of that.
struct OwnErrors {
  ErrorOf own_m;
  ErrorOf mapping_m;
};

std::optional<double> unknown(std::size_t, std::size_t) { return std::nullopt; }

ErrorOf errors_of(const MeasuredError& measured, double ErrorRow::*error_m) {
  return [&measured, error_m](std::size_t site, std::size_t look) -> std::optional<double> {
    if (measured.scan_of_site[site] < 0) return std::nullopt;
    return measured.row(site, look).*error_m;
  };
}

Result<std::size_t> stand_in_of(const FactorTable& factors) {
  const auto found = std::ranges::find(factors.factors, kStandIn);
  if (found != factors.factors.end()) {
    return static_cast<std::size_t>(found - factors.factors.begin());
  }
  return mismatched(std::string("the factors have no ") + kStandIn);
}

// What a table is made of.
struct Columns {
  const FactorTable& factors;
  std::size_t stand_in = 0;
  bool has_mark = false;  // the column that says where evidence comes from

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all = factors.factors;
    if (has_mark) all.emplace_back(kSimulatedColumn);
    return all;
  }
  void put(std::size_t site, std::size_t look, std::vector<double>& values) const {
    for (std::size_t f = 0; f < factors.factors.size(); ++f) {
      values.push_back(factors.at(site, look, f));
    }
    if (has_mark) values.push_back(1.0);
  }
};

// Two more columns.
FactorTable with_columns(const Columns& columns, const OwnErrors& errors) {
  const FactorTable& factors = columns.factors;
  FactorTable table;
  table.looks = factors.looks;
  table.factors = columns.names();
  table.factors.insert(table.factors.end(), {"own_error", "mapping_error"});
  table.site_count = factors.site_count;
  table.values.reserve(table.shape().size(table.site_count));
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t look = 0; look < factors.looks.size(); ++look) {
      columns.put(site, look, table.values);
      const double stand_in_m = factors.at(site, look, columns.stand_in);
      table.values.push_back(errors.own_m(site, look).value_or(stand_in_m));
      table.values.push_back(errors.mapping_m(site, look).value_or(stand_in_m));
    }
  }
  return table;
}

// The factors of looks that take a sample: those of the longest range, which all looks share, then
// the two columns above, then what the looks say together and what each costs.
constexpr const char* kSampleColumns[] = {"own_error",          "mapping_error",
                                          "mapping_error_mean", "mapping_error_max",
                                          "look_number",        "match_cost"};

FactorTable factors_of_samples(const Columns& columns, const std::vector<Look>& looks,
                               const OwnErrors& errors) {
  FactorTable table;
  table.looks = looks;
  table.factors = columns.names();
  table.shared_count = static_cast<std::uint32_t>(table.factors.size());
  table.factors.insert(table.factors.end(), std::begin(kSampleColumns), std::end(kSampleColumns));
  table.site_count = columns.factors.site_count;
  table.values.reserve(table.values_per_site() * table.site_count);
  const std::size_t longest = columns.factors.looks.size() - 1;
  for (std::size_t site = 0; site < table.site_count; ++site) {
    columns.put(site, longest, table.values);
    const double stand_in_m = columns.factors.at(site, longest, columns.stand_in);
    std::vector<double> mapping_m;
    for (std::size_t look = 0; look < looks.size(); ++look) {
      mapping_m.push_back(errors.mapping_m(site, look).value_or(stand_in_m));
    }
    const double mean_m = ordered_sum(mapping_m) / static_cast<double>(mapping_m.size());
    for (std::size_t look = 0; look < looks.size(); ++look) {
      table.values.insert(
          table.values.end(),
          {errors.own_m(site, look).value_or(stand_in_m), mapping_m[look], mean_m,
           std::ranges::max(mapping_m), static_cast<double>(look), expected_cost(looks[look])});
    }
  }
  return table;
}

Result<void> check_measured(const StoredTable<FactorTable>& map_factors,
                            const StoredTable<MeasuredError>& measured) {
  if (measured.row_count() == map_factors.row_count() &&
      measured.head().looks == map_factors.head().looks) {
    return {};
  }
  return mismatched(concat("the mapping drive was localized at ", measured.row_count(),
                           " sites, expected the factors' ", map_factors.row_count(),
                           " and their ranges"));
}

// As evidence a simulated error counts twice: surface and NDs are of the same points, and where a
// simulated scan ended within 10 cm, up to a quarter of a real drive's did not.
constexpr double kEvidenceFactor = 2.0;

ErrorOf as_evidence(ErrorOf errors_m) {
  return [errors_m = std::move(errors_m)](std::size_t site,
                                          std::size_t look) -> std::optional<double> {
    const std::optional<double> error_m = errors_m(site, look);
    return error_m ? std::optional(kEvidenceFactor * *error_m) : std::nullopt;
  };
}

// How the errors of the map's own scans are used.
enum class Use {
  kNone,      // of another sensor than the one that will localize
  kEvidence,  // a model learns from other scans of the same drive
  kFactor,    // as evidence, and for models to learn from
  kSimulated
};

OwnErrors errors_in(const MeasuredError& own, Use use) {
  const ErrorOf error_m = errors_of(own, &ErrorRow::mean_m);
  switch (use) {
    case Use::kNone:
      return {unknown, unknown};
    case Use::kEvidence:
      return {error_m, unknown};
    case Use::kFactor:
      return {error_m, errors_of(own, &ErrorRow::from_given_m)};
    case Use::kSimulated:
      break;
  }
  return {as_evidence(error_m), error_m};
}

// The factors of some sites with the errors of a family's looks.
Result<FactorTable> with_errors(const FactorTable& map_factors, const MeasuredError& own, Use use) {
  SIGHTLINE_ASSIGN(const std::size_t stand_in, stand_in_of(map_factors));
  const Columns columns{map_factors, stand_in, use == Use::kSimulated};
  const OwnErrors errors = errors_in(own, use);
  return takes_every_return(own.looks.front()) ? with_columns(columns, errors)
                                               : factors_of_samples(columns, own.looks, errors);
}

Use use_of(const PassContext& ctx, const MeasuredError& own, const SensorProfile* mapping_sensor,
           const SensorProfile& localizing_sensor) {
  if (own.reference == ErrorReference::kSimulated) return Use::kSimulated;
  if (mapping_sensor == nullptr) return Use::kEvidence;
  if (to_bytes(*mapping_sensor) == to_bytes(localizing_sensor)) return Use::kFactor;
  ctx.warn(concat("sensor ", mapping_sensor->name, " made the map, but ", localizing_sensor.name,
                  " localizes in it: mapping_error is computed from virtual scans"));
  return Use::kNone;
}

// All sites by the looks of a family, stretch by stretch.
Result<StoredTable<FactorTable>> with_all_errors(const StoredTable<FactorTable>& map_factors,
                                                 const StoredTable<MeasuredError>& own, Use use) {
  const auto of_stretch = [&](std::size_t first, std::size_t count) -> Result<FactorTable> {
    SIGHTLINE_ASSIGN(const FactorTable factors, map_factors.rows(first, count));
    SIGHTLINE_ASSIGN(const MeasuredError measured, own.rows(first, count));
    return with_errors(factors, measured, use);
  };
  const std::size_t site_count = map_factors.row_count();
  SIGHTLINE_ASSIGN(FactorTable head, of_stretch(0, 0));
  head.site_count = static_cast<std::uint32_t>(site_count);
  StoredTableWriter<FactorTable> writer(head);
  for (std::size_t first = 0; first < site_count; first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, site_count - first);
    SIGHTLINE_ASSIGN(const FactorTable some, of_stretch(first, count));
    writer.put(first, some);
  }
  return writer.take();
}

}  // namespace

Result<ByFamily<StoredTable<FactorTable>>> add_mapping_error(
    PassContext& ctx, const NoOptions&, const StoredTable<FactorTable>& map_factors,
    const ByFamily<StoredTable<MeasuredError>>& own, const SensorProfile* mapping_sensor,
    const SensorProfile& localizing_sensor) {
  SIGHTLINE_TRY(check_measured(map_factors, own.ranges));
  const Use use = use_of(ctx, own.ranges.head(), mapping_sensor, localizing_sensor);
  const auto of_family = [&](const StoredTable<MeasuredError>& errors) {
    return with_all_errors(map_factors, errors, use);
  };
  return each_family(of_family, own);
}

}  // namespace sightline
