#include <algorithm>

#include "compiler/views/picture/route_svg.h"
#include "compiler/views/report/page/page_assets.h"
#include "compiler/views/report/page/pictures.h"
#include "compiler/views/report/sections/sections.h"

// The counterpart of the paper's Figure 11: the map from above, the route coloured by range.

namespace sightline {
namespace {

constexpr double kMargin_m = 15.0;

std::string number(double value) { return fixed(value, 2); }

std::string legend(const CompiledMap& map) {
  std::string html = "<div class=\"legend\">range (m): ";
  for (std::size_t i = 0; i < map.ranges.looks.size(); ++i) {
    html += "<span><i style=\"background:" + range_colour(i) + "\"></i>" +
            fixed(map.ranges.looks[i].range_m, 0) + "</span> ";
  }
  return html + "</div>\n";
}

// The relief stands in the page once: pictures after the first use that one's.
std::string relief_image(const Overview& overview) {
  const MapBox& box = overview.box;
  return "<image id=\"relief\" class=\"relief\" x=\"" + number(box.low_x_m) + "\" y=\"" +
         number(-box.high_y_m) + "\" width=\"" + number(box.high_x_m - box.low_x_m) +
         "\" height=\"" + number(box.high_y_m - box.low_y_m) +
         "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," + overview.png_base64 +
         "\"/>\n";
}

std::string still_map(const ReportSources& sources, std::size_t limit) {
  const CompiledMap& map = *sources.map;
  const MapBox box = box_of_route(map.sites, kMargin_m);
  const double width_m = box.high_x_m - box.low_x_m;
  const double height_m = box.high_y_m - box.low_y_m;
  std::string svg = "<svg class=\"still-map\" role=\"img\" viewBox=\"" + number(box.low_x_m) + " " +
                    number(-box.high_y_m) + " " + number(width_m) + " " + number(height_m) +
                    "\"><title>The route from above, coloured by range</title>\n";
  if (sources.surface && limit > 0) {
    svg += "<use href=\"#relief\"/>\n";
  } else if (sources.surface) {
    const std::optional<Overview> overview =
        relief_overview(*sources.surface, map.sites, map.sensor.height_m);
    if (overview) svg += relief_image(*overview);
  }
  const double route_m = std::max(width_m, height_m) / 150.0;
  return svg + route_svg(map.sites, map.ranges, limit, route_m, range_colour) +
         scale_bar_svg(box, "currentColor") + "</svg>\n";
}

}  // namespace

Section map_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"map", "The map", ""};
  Figure figure = {"figure-11", "Figure 11.", "", "", "map"};
  figure.caption =
      "How far a vehicle must look at each place, from above (north up, map coordinates).";
  if (sources.surface) {
    figure.caption += " Grey: what the mapping drive saw, the darker the higher over the road.";
  }
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
