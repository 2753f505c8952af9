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
  return drive == 0 ? column : std::string(column) + "[" + std::to_string(drive + 1) + "]";
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
  for (const FactorTable& samples : factors.of_samples) {
    std::optional<MeasuredError> of_samples = drive_of_columns(samples, drive);
    if (of_samples) measured.of_samples.push_back(std::move(*of_samples));
  }
  return measured;
}

}  // namespace

FactorTable with_measured_columns(const FactorTable& factors, const MeasuredError& measured,
                                  bool is_independent) {
  FactorTable table = factors;
  const std::size_t drive = drives_in(factors);
  for (const MeasuredColumn& column : kMeasuredColumns) {
    table.factors.push_back(name_of(column.name, drive));
  }
  if (is_independent) table.factors.push_back(name_of(kIndependent, drive));
  table.values.clear();
  const std::size_t factor_count = factors.factors.size();
  const SiteShape shape{factors.looks.size()};
  for (std::size_t row = 0; row < shape.size(factors.site_count); ++row) {
    const auto values = factors.values.begin() + static_cast<std::ptrdiff_t>(row * factor_count);
    table.values.insert(table.values.end(), values,
                        values + static_cast<std::ptrdiff_t>(factor_count));
    const bool is_measured = measured.scan_of_site[shape.site_of(row)] >= 0;
    for (const MeasuredColumn& column : kMeasuredColumns) {
      table.values.push_back(is_measured ? measured.rows[row].*column.number : kNotMeasured);
    }
    if (is_independent) table.values.push_back(1.0);
  }
  if (measured.of_samples.empty()) return table;
  for (FactorTable& samples : table.of_samples) {
    samples = with_measured_columns(samples, measured.of_samples.front(), is_independent);
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

std::vector<MeasuredError> measured_of_columns(const FactorTable& factors) {
  std::vector<MeasuredError> drives;
  for (std::size_t drive = 0; drive < drives_in(factors); ++drive) {
    std::optional<MeasuredError> measured = drive_of_columns(factors, drive);
    if (!measured) return {};
    drives.push_back(std::move(*measured));
  }
  return drives;
}

}  // namespace sightline
