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

std::string relief_image(const Overview& overview) {
  const MapBox& box = overview.box;
  return "<image id=\"relief\" class=\"relief\" x=\"" + number(box.low_x_m) + "\" y=\"" +
         number(-box.high_y_m) + "\" width=\"" + number(box.high_x_m - box.low_x_m) +
         "\" height=\"" + number(box.high_y_m - box.low_y_m) +
         "\" preserveAspectRatio=\"none\" href=\"data:image/png;base64," + overview.png_base64 +
         "\"/>\n";
}

// What the mapping drive saw, once in the page; pictures after the first use that one's.
std::string background_of(const ReportSources& sources, std::size_t limit) {
  if (!sources.surface) return "";
  if (limit > 0) return "<use href=\"#relief\"/>\n";
  const std::optional<Overview> overview =
      relief_overview(*sources.surface, sources.map->sites, sources.map->sensor.height_m);
  return overview ? relief_image(*overview) : "";
}

}  // namespace

std::string still_route(const Sites& sites, const RangeTable& choice, std::size_t limit,
                        const RouteColours& colours, const std::string& background) {
  const MapBox box = box_of_route(sites, kMargin_m);
  const double width_m = box.high_x_m - box.low_x_m;
  const double height_m = box.high_y_m - box.low_y_m;
  const double route_m = std::max(width_m, height_m) / 150.0;
  return "<svg class=\"still-map\" role=\"img\" viewBox=\"" + number(box.low_x_m) + " " +
         number(-box.high_y_m) + " " + number(width_m) + " " + number(height_m) +
         "\"><title>The route from above, coloured by " + colours.by + "</title>\n" + background +
         route_svg(sites, choice, limit, route_m, colours.colour_of) +
         scale_bar_svg(box, "currentColor") + "</svg>\n";
}

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
                           "</h3>\n" +
                           still_route(map.sites, map.ranges, limit, {"range", &range_colour},
                                       background_of(sources, limit)) +
                           legend(map);
  }
  section.html = html_figure(figure);
  return section;
}

}  // namespace sightline
