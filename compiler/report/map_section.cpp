#include <algorithm>
#include <cmath>

#include "compiler/report/page_assets.h"
#include "compiler/report/pictures.h"
#include "compiler/report/sections.h"

// The counterpart of the paper's Figure 11: the map from above, the route coloured by range.

namespace sightline {
namespace {

constexpr double kMargin_m = 15.0;

MapBox box_of_route(const CompiledMap& map) {
  Eigen::AlignedBox2d around;
  for (const Site& site : map.sites.sites) around.extend(site.p_map_m.head<2>());
  if (around.isEmpty()) return {};
  return {around.min().x() - kMargin_m, around.min().y() - kMargin_m, around.max().x() + kMargin_m,
          around.max().y() + kMargin_m};
}

std::string number(double value) { return fixed(value, 2); }

// One path for each stretch of sites of one range. y grows downwards: everything is drawn at -y.
std::string route_paths(const CompiledMap& map, std::size_t limit, double width_m) {
  const auto range_of = [&](std::size_t site) { return map.ranges.range(site, limit); };
  std::string svg;
  std::string path;
  for (std::size_t i = 0; i < map.sites.sites.size(); ++i) {
    const Eigen::Vector3d& p_m = map.sites.sites[i].p_map_m;
    const bool goes_on = i > 0 && map.sites.sites[i].run == map.sites.sites[i - 1].run;
    path += (goes_on && !path.empty() ? "L" : "M") + number(p_m.x()) + " " + number(-p_m.y());
    const bool is_last = i + 1 == map.sites.sites.size() ||
                         map.sites.sites[i + 1].run != map.sites.sites[i].run ||
                         range_of(i + 1) != range_of(i);
    if (!is_last) continue;
    svg += "<path d=\"" + path +
           "h.01\" style=\"fill:none;stroke-linecap:round;stroke-width:" + number(width_m) +
           ";stroke:" + range_colour(range_of(i)) + "\"/>\n";
    path.clear();
    // The next stretch begins where this one ends.
    if (i + 1 < map.sites.sites.size() && map.sites.sites[i + 1].run == map.sites.sites[i].run) {
      path = "M" + number(p_m.x()) + " " + number(-p_m.y());
    }
  }
  return svg;
}

std::string legend(const CompiledMap& map) {
  std::string html = "<div class=\"legend\">range (m): ";
  for (std::size_t i = 0; i < map.ranges.ranges_m.size(); ++i) {
    html += "<span><i style=\"background:" + range_colour(i) + "\"></i>" +
            fixed(map.ranges.ranges_m[i], 0) + "</span> ";
  }
  return html + "</div>\n";
}

std::string scale_bar(const MapBox& box) {
  const double width_m = box.high_x_m - box.low_x_m;
  const double power_m = std::pow(10.0, std::floor(std::log10(width_m / 4.0)));
  const double length_m = power_m * (width_m / 4.0 >= 5.0 * power_m   ? 5.0
                                     : width_m / 4.0 >= 2.0 * power_m ? 2.0
                                                                      : 1.0);
  const double x_m = box.low_x_m + 0.03 * width_m;
  const double y_m = -box.low_y_m - 0.03 * width_m;
  return "<path d=\"M" + number(x_m) + " " + number(y_m) + "h" + number(length_m) +
         "\" style=\"stroke:currentColor;stroke-width:" + number(width_m / 250.0) +
         "\"/><text x=\"" + number(x_m) + "\" y=\"" + number(y_m - 0.012 * width_m) +
         "\" font-size=\"" + number(width_m / 55.0) + "\" fill=\"currentColor\">" +
         metres(length_m) + "</text>\n";
}

std::string still_map(const ReportSources& sources, std::size_t limit) {
  const CompiledMap& map = *sources.map;
  const MapBox box = box_of_route(map);
  const double width_m = box.high_x_m - box.low_x_m;
  const double height_m = box.high_y_m - box.low_y_m;
  std::string svg = "<svg class=\"still-map\" role=\"img\" viewBox=\"" + number(box.low_x_m) + " " +
                    number(-box.high_y_m) + " " + number(width_m) + " " + number(height_m) +
                    "\"><title>The route from above, coloured by range</title>\n";
  if (sources.surface) {
    const std::optional<Overview> overview =
        relief_overview(*sources.surface, map.sites, map.sensor.height_m);
    if (overview) {
      const MapBox& picture = overview->box;
      svg += "<image class=\"relief\" x=\"" + number(picture.low_x_m) + "\" y=\"" +
             number(-picture.high_y_m) + "\" width=\"" +
             number(picture.high_x_m - picture.low_x_m) + "\" height=\"" +
             number(picture.high_y_m - picture.low_y_m) +
             "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," +
             overview->png_base64 + "\"/>\n";
    }
  }
  return svg + route_paths(map, limit, std::max(width_m, height_m) / 150.0) + scale_bar(box) +
         "</svg>\n";
}

}  // namespace

Section map_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"map", "The map", ""};
  Figure figure = {"figure-11", "Figure 11.", "", "", "map"};
  figure.caption =
      "How far a vehicle must look at each place, from above (north up, map coordinates). Grey: "
      "what the mapping drive saw, the darker the higher over the road.";
  if (!page_script().empty()) {
    figure.caption +=
        " Click the route, or use the buttons, to see why a site looks as far as it does.";
  }
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    figure.picture_html += "<h3>Limit " + limit_text(map.ranges.promises[limit].limit_m) +
                           "</h3>\n" + still_map(sources, limit) + legend(map);
  }
  section.html = html_figure(figure);
  return section;
}

}  // namespace sightline
