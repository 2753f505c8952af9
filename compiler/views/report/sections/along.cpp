#include "compiler/views/report/sections/along.h"

#include <limits>

#include "compiler/views/report/page/page_data.h"
#include "formats/grid/site_shape.h"

namespace sightline {
namespace {

// Where the number of a judged site is, at the range that a rule takes.
std::size_t cell_of(const Evaluation& evaluation, std::size_t limit, Rule rule, std::size_t i) {
  return SiteShape{evaluation.statics.size()}.index(i, evaluation.chosen(limit, rule, i));
}

}  // namespace

Along::Along(const Evaluation& evaluation, const Sites& sites)
    : evaluation_(&evaluation), spacing_m_(sites.spacing_m) {
  const std::vector<double> route_m = route_of_sites_m(sites);
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    route_m_.push_back(route_m[site.site]);
    is_after_gap_.push_back(i > 0 && (evaluation.sites[i - 1].run != site.run ||
                                      evaluation.sites[i - 1].site + 1 != site.site));
  }
}

ChartSeries Along::series(const std::string& name, const std::string& colour,
                          const std::function<double(std::size_t)>& value_of) const {
  ChartSeries series = {name, colour};
  for (std::size_t i = 0; i < route_m_.size(); ++i) {
    if (is_after_gap_[i]) series.add(route_m_[i], std::numeric_limits<double>::quiet_NaN());
    series.add(route_m_[i], value_of(i));
  }
  return series;
}

ChartSeries Along::times(const std::string& name, const std::string& colour, std::size_t limit,
                         Rule rule) const {
  return series(name, colour, [&](std::size_t i) {
    return evaluation_->time_ms[cell_of(*evaluation_, limit, rule, i)];
  });
}

ChartSeries Along::ranges(const std::string& name, const std::string& colour, std::size_t limit,
                          Rule rule) const {
  ChartSeries steps = series(name, colour, [&](std::size_t i) {
    return evaluation_->statics[evaluation_->chosen(limit, rule, i)].range_m;
  });
  steps.mark = Mark::kSteps;
  return steps;
}

std::vector<ChartBand> Along::misses(std::size_t limit) const {
  std::vector<ChartBand> bands;
  for (std::size_t i = 0; i < route_m_.size(); ++i) {
    const double error_m = evaluation_->error_m[cell_of(*evaluation_, limit, Rule::kMap, i)];
    if (!(error_m > evaluation_->limits_m[limit])) continue;
    const double from_m = route_m_[i] - spacing_m_ / 2.0;
    const bool goes_on = !bands.empty() && from_m - bands.back().to_x < spacing_m_ / 4.0;
    if (!goes_on) bands.push_back({from_m, from_m});
    bands.back().to_x = from_m + spacing_m_;
  }
  return bands;
}

Chart route_chart(const std::string& title, const std::string& y_label, double height_px) {
  Chart chart = {title, "distance along the route (m)", y_label, 1080.0, height_px};
  chart.least_y = 0.0;
  chart.band_colour = "var(--pink)";
  return chart;
}

}  // namespace sightline
