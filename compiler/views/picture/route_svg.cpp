#include "compiler/views/picture/route_svg.h"

#include <cmath>

#include "formats/text/numbers.h"

namespace sightline {
namespace {

std::string number(double value) { return fixed(value, 2); }

// 1, 2 or 5 times a power of ten.
double round_length_m(double most_m) {
  const double power_m = std::pow(10.0, std::floor(std::log10(most_m)));
  if (most_m >= 5.0 * power_m) return 5.0 * power_m;
  return most_m >= 2.0 * power_m ? 2.0 * power_m : power_m;
}

}  // namespace

MapBox box_of_route(const Sites& sites, double margin_m) {
  Eigen::AlignedBox2d around;
  for (const Site& site : sites.sites) around.extend(site.p_map_m.head<2>());
  if (around.isEmpty()) return {};
  return {around.min().x() - margin_m, around.min().y() - margin_m, around.max().x() + margin_m,
          around.max().y() + margin_m};
}

std::string route_svg(const Sites& sites, const RangeTable& ranges, std::size_t limit,
                      double width_m, const std::function<std::string(std::size_t)>& colour_of) {
  const auto range_of = [&](std::size_t site) { return ranges.range(site, limit); };
  std::string svg;
  std::string path;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Eigen::Vector3d& p_m = sites.sites[i].p_map_m;
    path += (path.empty() ? "M" : "L") + number(p_m.x()) + " " + number(-p_m.y());
    const bool goes_on = i + 1 < sites.sites.size() && sites.sites[i + 1].run == sites.sites[i].run;
    if (goes_on && range_of(i + 1) == range_of(i)) continue;
    svg += "<path d=\"" + path +
           "h.01\" style=\"fill:none;stroke-linecap:round;stroke-width:" + number(width_m) +
           ";stroke:" + colour_of(range_of(i)) + "\"/>\n";
    // The next stretch of a run begins where this one ends.
    path = goes_on ? "M" + number(p_m.x()) + " " + number(-p_m.y()) : "";
  }
  return svg;
}

std::string scale_bar_svg(const MapBox& box, const std::string& colour) {
  const double width_m = box.high_x_m - box.low_x_m;
  const double length_m = round_length_m(width_m / 4.0);
  const double x_m = box.low_x_m + 0.03 * width_m;
  const double y_m = -box.low_y_m - 0.03 * width_m;
  return "<path d=\"M" + number(x_m) + " " + number(y_m) + "h" + number(length_m) +
         "\" style=\"stroke:" + colour + ";stroke-width:" + number(width_m / 250.0) +
         "\"/><text x=\"" + number(x_m) + "\" y=\"" + number(y_m - 0.012 * width_m) +
         "\" font-size=\"" + number(width_m / 55.0) + "\" fill=\"" + colour + "\">" +
         fixed(length_m, length_m < 1.0 ? 2 : 0) + " m</text>\n";
}

}  // namespace sightline
