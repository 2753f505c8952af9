#include "passes/model/forest/measured_columns.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace sightline {
namespace {

// The numbers of an earlier drive's rows that history is made of.
struct MeasuredColumn {
  const char* name;
  double ErrorRow::*number;
};
constexpr MeasuredColumn kMeasuredColumns[] = {{"measured_mean_m", &ErrorRow::mean_m},
                                               {"measured_p90_m", &ErrorRow::p90_m},
                                               {"measured_lost_share", &ErrorRow::lost_share}};
constexpr double kNotMeasured = -1.0;
constexpr const char* kIndependent = "measured_is_independent";

// Of the drive with this number, from 0 on.
std::string name_of(const char* column, std::size_t drive) {
  return drive == 0 ? column : concat(column, "[", drive + 1, "]");
}

std::optional<std::size_t> column_of(const FactorTable& factors, const std::string& name) {
  const auto found = std::ranges::find(factors.factors, name);
  if (found == factors.factors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - factors.factors.begin());
}

std::size_t drives_in(const FactorTable& factors) {
  std::size_t count = 0;
  while (column_of(factors, name_of(kMeasuredColumns[0].name, count))) ++count;
  return count;
}

// Nothing where a column of the drive is missing.
std::optional<MeasuredError> drive_of_columns(const FactorTable& factors, std::size_t drive) {
  MeasuredError measured;
  measured.looks = factors.looks;
  measured.scan_of_site.assign(factors.site_count, 0);
  measured.rows.resize(measured.shape().size(factors.site_count));
  const SiteShape shape = measured.shape();
  for (const MeasuredColumn& column : kMeasuredColumns) {
    const std::optional<std::size_t> factor = column_of(factors, name_of(column.name, drive));
    if (!factor) return std::nullopt;
    for (std::size_t row = 0; row < measured.rows.size(); ++row) {
      const double value = factors.at(shape.site_of(row), shape.row_of(row), *factor);
      measured.rows[row].*column.number = value;
      if (value == kNotMeasured) measured.scan_of_site[shape.site_of(row)] = -1;
    }
  }
  return measured;
}

// Of one family.
FactorTable with_own_columns(const FactorTable& factors, const MeasuredError& measured,
                             bool is_independent) {
  FactorTable table;
  table.looks = factors.looks;
  table.factors = factors.factors;
  table.site_count = factors.site_count;
  table.shared_count = factors.shared_count;
  const std::size_t drive = drives_in(factors);
  for (const MeasuredColumn& column : kMeasuredColumns) {
    table.factors.push_back(name_of(column.name, drive));
  }
  if (is_independent) table.factors.push_back(name_of(kIndependent, drive));
  table.values.reserve(table.values_per_site() * table.site_count);
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t f = 0; f < factors.shared_count; ++f) {
      table.values.push_back(factors.at(site, 0, f));
    }
    const bool is_measured = measured.scan_of_site[site] >= 0;
    for (std::size_t look = 0; look < factors.looks.size(); ++look) {
      for (std::size_t f = factors.shared_count; f < factors.factors.size(); ++f) {
        table.values.push_back(factors.at(site, look, f));
      }
      for (const MeasuredColumn& column : kMeasuredColumns) {
        table.values.push_back(is_measured ? measured.row(site, look).*column.number
                                           : kNotMeasured);
      }
      if (is_independent) table.values.push_back(1.0);
    }
  }
  return table;
}

}  // namespace

ByFamily<FactorTable> with_measured_columns(const ByFamily<FactorTable>& factors,
                                            const ByFamily<MeasuredError>& measured,
                                            bool is_independent) {
  ByFamily<FactorTable> table(with_own_columns(factors.ranges, measured.ranges, is_independent),
                              factors.samples);
  if (factors.samples && measured.samples) {
    table.samples = with_own_columns(*factors.samples, *measured.samples, is_independent);
  }
  return table;
}

std::vector<bool> independence_of_columns(const FactorTable& factors) {
  std::vector<bool> is_independent;
  for (std::size_t drive = 0; drive < drives_in(factors); ++drive) {
    is_independent.push_back(column_of(factors, name_of(kIndependent, drive)).has_value());
  }
  return is_independent;
}

bool has_measured_columns(const FactorTable& factors) { return drives_in(factors) > 0; }

std::vector<ByFamily<MeasuredError>> measured_of_columns(const ByFamily<FactorTable>& factors) {
  std::vector<ByFamily<MeasuredError>> drives;
  for (std::size_t drive = 0; drive < drives_in(factors.ranges); ++drive) {
    std::optional<MeasuredError> measured = drive_of_columns(factors.ranges, drive);
    if (!measured) return {};
    drives.emplace_back(std::move(*measured));
    if (factors.samples) drives.back().samples = drive_of_columns(*factors.samples, drive);
  }
  return drives;
}

}  // namespace sightline
