#include "compiler/views/text/factor_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "formats/record/cells.h"

namespace sightline {
namespace {

// Ranks from 0; equal values share their mean rank.
std::vector<double> ranks_of(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return values[a] != values[b] ? values[a] < values[b] : a < b;
  });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      ranks[order[i]] = 0.5 * static_cast<double>(begin + end - 1);
    }
    begin = end;
  }
  return ranks;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

struct Line {
  double at_zero = 0.0;
  double slope = 0.0;
  double correlation = 0.0;  // 0 where x or y never differ
};

Line line_through(const std::vector<double>& x, const std::vector<double>& y) {
  const double mean_x = mean_of(x);
  const double mean_y = mean_of(y);
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  Line line;
  line.slope = xx > 0.0 ? xy / xx : 0.0;
  line.at_zero = mean_y - line.slope * mean_x;
  line.correlation = xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
  return line;
}

// Columns over the measured sites, of one range or of several one after another.
struct Columns {
  std::vector<double> virtual_points;
  std::vector<double> points;
  std::vector<double> work;
  std::vector<double> time_ms;
};

void append(const ErrorRow& row, double virtual_points, Columns& columns) {
  columns.virtual_points.push_back(virtual_points);
  columns.points.push_back(row.point_count);
  columns.work.push_back(row.mean_work);
  columns.time_ms.push_back(row.mean_time_ms);
}

std::vector<double> rank_correlations(const FactorTable& factors, const MeasuredError& measured,
                                      const std::vector<std::size_t>& sites, std::size_t range) {
  std::vector<double> error_m;
  for (const std::size_t site : sites) error_m.push_back(measured.row(site, range).mean_m);
  const std::vector<double> error_ranks = ranks_of(error_m);
  std::vector<double> correlations;
  for (std::size_t factor = 0; factor < factors.factors.size(); ++factor) {
    std::vector<double> column;
    for (const std::size_t site : sites) column.push_back(factors.at(site, range, factor));
    correlations.push_back(line_through(ranks_of(column), error_ranks).correlation);
  }
  return correlations;
}

Result<std::vector<std::size_t>> sites_in_both(const FactorTable& factors,
                                               const MeasuredError& measured) {
  if (factors.site_count != measured.scan_of_site.size() || factors.looks != measured.looks) {
    return Error{ErrorCode::kMismatchedInputs,
                 "factors and measured errors are of different sites or ranges"};
  }
  std::vector<std::size_t> sites;
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    if (measured.scan_of_site[site] >= 0) sites.push_back(site);
  }
  if (sites.empty()) {
    return Error{ErrorCode::kNoOverlap, "no site was measured"};
  }
  return sites;
}

std::string line_of(const std::string& name, const FactorReport& report,
                    const std::function<double(const FactorsAtRange&)>& value, int decimals) {
  std::string text = fmt::format("{:22}", name);
  for (const FactorsAtRange& range : report.ranges) {
    text += fmt::format(" {:>6.{}f}", value(range), decimals);
  }
  return text + "\n";
}

}  // namespace

Result<FactorReport> factor_report(const FactorTable& factors, const MeasuredError& measured) {
  SIGHTLINE_ASSIGN(const std::vector<std::size_t> sites, sites_in_both(factors, measured));
  const auto points = std::find(factors.factors.begin(), factors.factors.end(), "virtual_points");
  if (points == factors.factors.end()) {
    return Error{ErrorCode::kMismatchedInputs, "the factors have no virtual_points"};
  }
  const auto points_column = static_cast<std::size_t>(points - factors.factors.begin());
  FactorReport report;
  report.factors = factors.factors;
  Columns all;
  for (std::size_t range = 0; range < factors.looks.size(); ++range) {
    Columns here;
    for (const std::size_t site : sites) {
      const double virtual_points = factors.at(site, range, points_column);
      append(measured.row(site, range), virtual_points, here);
      append(measured.row(site, range), virtual_points, all);
    }
    FactorsAtRange& row = report.ranges.emplace_back();
    row.range_m = factors.looks[range].range_m;
    row.rank_correlation = rank_correlations(factors, measured, sites, range);
    row.virtual_points = mean_of(here.virtual_points);
    row.measured_points = mean_of(here.points);
    row.point_correlation = line_through(here.virtual_points, here.points).correlation;
    row.measured_work = mean_of(here.work);
    row.measured_time_ms = mean_of(here.time_ms);
  }
  const Line work = line_through(all.virtual_points, all.work);
  const Line time_ms = line_through(all.virtual_points, all.time_ms);
  for (FactorsAtRange& row : report.ranges) {
    row.expected_work = work.at_zero + work.slope * row.virtual_points;
    row.expected_time_ms = time_ms.at_zero + time_ms.slope * row.virtual_points;
  }
  report.point_correlation = line_through(all.virtual_points, all.points).correlation;
  return report;
}

std::vector<Table> tables(const FactorReport& report) {
  Table ranks;
  ranks.name = "factor-rank-correlation";
  ranks.columns = {"factor", "range_m", "rank_correlation"};
  for (std::size_t factor = 0; factor < report.factors.size(); ++factor) {
    for (const FactorsAtRange& range : report.ranges) {
      ranks.rows.push_back({report.factors[factor], range.range_m, range.rank_correlation[factor]});
    }
  }
  Table expected = table_of("expected-time", report.ranges);
  expected.facts = {{"point_correlation", report.point_correlation}};
  return {ranks, expected};
}

std::string to_text(const FactorReport& report) {
  const auto line = [&](const char* name, double FactorsAtRange::*field, int decimals) {
    return line_of(
        name, report, [&](const FactorsAtRange& range) { return range.*field; }, decimals);
  };
  std::string text =
      fmt::format("Matching time expected from virtual points (r of all counts {:.3f})\n",
                  report.point_correlation) +
      line("range (m)", &FactorsAtRange::range_m, 0) +
      line("virtual points", &FactorsAtRange::virtual_points, 0) +
      line("measured points", &FactorsAtRange::measured_points, 0) +
      line("correlation (r)", &FactorsAtRange::point_correlation, 3) +
      line("expected time (ms)", &FactorsAtRange::expected_time_ms, 2) +
      line("measured time (ms)", &FactorsAtRange::measured_time_ms, 2) +
      line("expected work", &FactorsAtRange::expected_work, 0) +
      line("measured work", &FactorsAtRange::measured_work, 0);
  text += "\nRank correlation of each factor with the measured mean error\n";
  text += line("range (m)", &FactorsAtRange::range_m, 0);
  for (std::size_t factor = 0; factor < report.factors.size(); ++factor) {
    text += line_of(
        report.factors[factor], report,
        [&](const FactorsAtRange& range) { return range.rank_correlation[factor]; }, 2);
  }
  return text;
}

}  // namespace sightline
