#pragma once

#include <vector>

#include "compiler/views/picture/charts/chart.h"
#include "formats/annotation/sites.h"
#include "formats/evaluation/evaluation.h"

// Charts along the route, of the sites that a drive judged.

namespace sightline {

// Where the judged sites lie on the charts' x axis, with a break where the drive has a gap.
class Along {
 public:
  Along(const Evaluation& evaluation, const Sites& sites);

  // One number for each judged site, as a line.
  template <class Value>
  [[nodiscard]] ChartSeries series(const std::string& name, const std::string& colour,
                                   Value value_of) const {
    ChartSeries series;
    series.name = name;
    series.colour = colour;
    for (std::size_t i = 0; i < route_m_.size(); ++i) {
      if (is_after_gap_[i]) append_break(i, series);
      series.x.push_back(route_m_[i]);
      series.y.push_back(value_of(i));
    }
    return series;
  }

  // Stretches of judged sites of which something is so.
  template <class Claim>
  [[nodiscard]] std::vector<ChartBand> bands(Claim is_so) const {
    std::vector<ChartBand> bands;
    for (std::size_t i = 0; i < route_m_.size(); ++i) {
      if (!is_so(i)) continue;
      const double from_m = route_m_[i] - spacing_m_ / 2.0;
      const bool goes_on = !bands.empty() && from_m - bands.back().to_x < spacing_m_ / 4.0;
      if (goes_on) {
        bands.back().to_x = from_m + spacing_m_;
      } else {
        bands.push_back({from_m, from_m + spacing_m_});
      }
    }
    return bands;
  }

 private:
  void append_break(std::size_t judged, ChartSeries& series) const;

  double spacing_m_ = 1.0;
  std::vector<double> route_m_;
  std::vector<bool> is_after_gap_;
};

// A chart with the route as its x axis.
Chart route_chart(const std::string& title, const std::string& y_label);

}  // namespace sightline
