#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compiler/views/picture/charts/chart.h"
#include "formats/annotation/sites.h"
#include "formats/evaluation/evaluation.h"

namespace sightline {

// Lines of charts along the route: a number for each site that a drive judged, with a break where
// the drive has a gap.
class Along {
 public:
  // The evaluation outlives this.
  Along(const Evaluation& evaluation, const Sites& sites);

  [[nodiscard]] ChartSeries series(const std::string& name, const std::string& colour,
                                   const std::function<double(std::size_t)>& value_of) const;
  // Of the ranges that a rule takes at a limit: their matching times, or themselves in steps.
  [[nodiscard]] ChartSeries times(const std::string& name, const std::string& colour,
                                  std::size_t limit, Rule rule) const;
  [[nodiscard]] ChartSeries ranges(const std::string& name, const std::string& colour,
                                   std::size_t limit, Rule rule) const;
  // Stretches of judged sites where the range of the map misses a limit.
  [[nodiscard]] std::vector<ChartBand> misses(std::size_t limit) const;

 private:
  const Evaluation* evaluation_;
  double spacing_m_ = 1.0;
  std::vector<double> route_m_;
  std::vector<bool> is_after_gap_;
};

Chart route_chart(const std::string& title, const std::string& y_label, double height_px = 300.0);

}  // namespace sightline
