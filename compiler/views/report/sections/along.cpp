#include "compiler/views/report/sections/along.h"

#include <limits>

#include "compiler/views/report/page/page_data.h"

namespace sightline {

Along::Along(const Evaluation& evaluation, const Sites& sites) : spacing_m_(sites.spacing_m) {
  const std::vector<double> route_m = route_of_sites_m(sites);
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    const bool is_first = i == 0;
    route_m_.push_back(route_m[site.site]);
    is_after_gap_.push_back(!is_first && (evaluation.sites[i - 1].run != site.run ||
                                          evaluation.sites[i - 1].site + 1 != site.site));
  }
}

void Along::append_break(std::size_t judged, ChartSeries& series) const {
  series.x.push_back(route_m_[judged]);
  series.y.push_back(std::numeric_limits<double>::quiet_NaN());
}

Chart route_chart(const std::string& title, const std::string& y_label) {
  Chart chart;
  chart.title = title;
  chart.x_label = "way along the route (m)";
  chart.y_label = y_label;
  chart.least_y = 0.0;
  chart.width_px = 1080.0;
  chart.band_colour = "var(--pink)";
  return chart;
}

}  // namespace sightline
