#include "passes/model/forest/history.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

constexpr double kReach_m = 6.0;         // farther measurements say little of a place
constexpr double kLeastError_m = 0.001;  // below this the logarithm would magnify noise

// The numbers of an earlier drive's rows that history is made of.
struct MeasuredColumn {
  const char* name;
  double ErrorRow::*number;
};
constexpr MeasuredColumn kMeasuredColumns[] = {{"measured_mean_m", &ErrorRow::mean_m},
                                               {"measured_p90_m", &ErrorRow::p90_m},
                                               {"measured_lost_share", &ErrorRow::lost_share}};
constexpr double kNotMeasured = -1.0;

double log_error(double error_m) { return portable_log(std::max(error_m, kLeastError_m)); }

// Of each site, those that the drive measured within kReach_m, the nearest first, the lower index
// on a tie.
std::vector<std::vector<std::size_t>> measured_near(const Sites& sites,
                                                    const MeasuredError& measured) {
  std::vector<std::size_t> known;
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    if (measured.scan_of_site[site] < 0) continue;
    known.push_back(site);
    places_m.push_back(sites.sites[site].p_map_m);
  }
  const PointGrid grid(places_m);
  std::vector<std::vector<std::size_t>> near(sites.sites.size());
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    for (const NearPoint& point : grid.within(sites.sites[site].p_map_m, kReach_m)) {
      near[site].push_back(known[point.index]);
    }
  }
  return near;
}

// In the order of history_features(). `near` is not empty.
std::vector<double> describe(const MeasuredError& measured, const std::vector<std::size_t>& near,
                             std::size_t range) {
  const std::size_t nearest = near.front();
  const std::size_t longest = measured.looks.size() - 1;
  const ErrorRow& own = measured.row(nearest, range);
  std::vector<double> logs;
  double worst = -std::numeric_limits<double>::infinity();
  double lost_share = 0.0;
  for (const std::size_t site : near) {
    const ErrorRow& row = measured.row(site, range);
    logs.push_back(log_error(row.mean_m));
    worst = std::max(worst, logs.back());
    lost_share = std::max(lost_share, row.lost_share);
  }
  const double mean = ordered_sum(logs) / static_cast<double>(logs.size());
  return {1.0,
          log_error(own.mean_m),
          log_error(measured.row(nearest, range == 0 ? 0 : range - 1).mean_m),
          log_error(measured.row(nearest, std::min(range + 1, longest)).mean_m),
          mean,
          worst,
          log_error(own.p90_m),
          lost_share};
}

}  // namespace

const std::vector<std::string>& history_features() {
  static const std::vector<std::string> kNames = {
      "history_known",           "history_log_mean",      "history_log_mean_shorter",
      "history_log_mean_longer", "history_log_mean_near", "history_log_max_near",
      "history_log_p90",         "history_lost_near"};
  return kNames;
}

bool is_history_feature(const std::string& name) {
  return std::ranges::find(history_features(), name) != history_features().end();
}

History history_of(const Sites& sites, const MeasuredError& measured) {
  SIGHTLINE_CHECK(measured.scan_of_site.size() == sites.sites.size());
  const std::vector<std::vector<std::size_t>> near_of = measured_near(sites, measured);
  const std::size_t range_count = measured.looks.size();
  const SiteShape shape{range_count, history_features().size()};
  History history;
  history.is_known.assign(sites.sites.size(), 0);
  history.values.assign(shape.size(sites.sites.size()), 0.0F);
  for (std::size_t site = 0; site < sites.sites.size(); ++site) {
    const std::vector<std::size_t>& near = near_of[site];
    if (near.empty()) continue;
    history.is_known[site] = 1;
    for (std::size_t range = 0; range < range_count; ++range) {
      const std::vector<double> values = describe(measured, near, range);
      std::transform(values.begin(), values.end(),
                     history.values.begin() + static_cast<std::ptrdiff_t>(shape.index(site, range)),
                     [](double value) { return static_cast<float>(value); });
    }
  }
  return history;
}

FactorTable with_measured_columns(const FactorTable& factors, const MeasuredError& measured) {
  FactorTable table = factors;
  for (const MeasuredColumn& column : kMeasuredColumns) table.factors.emplace_back(column.name);
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
  }
  if (measured.of_samples.empty()) return table;
  for (FactorTable& samples : table.of_samples) {
    samples = with_measured_columns(samples, measured.of_samples.front());
  }
  return table;
}

std::optional<MeasuredError> measured_of_columns(const FactorTable& factors) {
  MeasuredError measured;
  measured.looks = factors.looks;
  measured.scan_of_site.assign(factors.site_count, 0);
  measured.rows.resize(measured.shape().size(factors.site_count));
  const SiteShape shape = measured.shape();
  for (const MeasuredColumn& column : kMeasuredColumns) {
    const auto found = std::ranges::find(factors.factors, column.name);
    if (found == factors.factors.end()) return std::nullopt;
    const auto factor = static_cast<std::size_t>(found - factors.factors.begin());
    for (std::size_t row = 0; row < measured.rows.size(); ++row) {
      const double value = factors.at(shape.site_of(row), shape.row_of(row), factor);
      measured.rows[row].*column.number = value;
      if (value == kNotMeasured) measured.scan_of_site[shape.site_of(row)] = -1;
    }
  }
  for (const FactorTable& samples : factors.of_samples) {
    std::optional<MeasuredError> of_samples = measured_of_columns(samples);
    if (of_samples) measured.of_samples.push_back(std::move(*of_samples));
  }
  return measured;
}

FeatureRows with_history(const FeatureRows& rows, const History* history) {
  const std::vector<std::string>& added = history_features();
  SIGHTLINE_CHECK(history == nullptr || history->values.size() == rows.row_count * added.size());
  FeatureRows out;
  out.names = rows.names;
  out.names.insert(out.names.end() - 1, added.begin(), added.end());
  out.row_count = rows.row_count;
  out.values.reserve(out.row_count * out.names.size());
  const std::size_t before = rows.names.size() - 1;  // range_m comes last
  for (std::size_t i = 0; i < rows.row_count; ++i) {
    const float* row = rows.row(i);
    out.values.insert(out.values.end(), row, row + before);
    for (std::size_t f = 0; f < added.size(); ++f) {
      out.values.push_back(history == nullptr ? 0.0F : history->values[i * added.size() + f]);
    }
    out.values.push_back(row[before]);
  }
  return out;
}

}  // namespace sightline
