#include <fmt/format.h>

#include <algorithm>

#include "compiler/views/picture/ranges_picture.h"
#include "compiler/views/report/page/page_assets.h"
#include "compiler/views/report/page/pictures.h"
#include "compiler/views/report/sections/sections.h"

namespace sightline {
namespace {

constexpr double kMargin_m = 15.0;

std::string legend(const CompiledMap& map) {
  std::string html = "<div class=\"legend\">range (m): ";
  for (std::size_t i = 0; i < map.ranges.looks.size(); ++i) {
    html += concat("<span><i style=\"background:", range_colour(i), "\"></i>",
                   fixed(map.ranges.looks[i].range_m, 0), "</span> ");
  }
  return html + "</div>\n";
}

std::string relief_image(const Overview& overview) {
  const MapBox& box = overview.box;
  return fmt::format(
      R"(<image id="relief" class="relief" x="{:.2f}" y="{:.2f}" width="{:.2f}" height="{:.2f}")"
      " preserveAspectRatio=\"none\" href=\"data:image/png;base64,{}\"/>\n",
      box.low_x_m, -box.high_y_m, box.width_m(), box.height_m(), overview.png_base64);
}

// Surface seen by the mapping drive, once in the page; later pictures use the first one's.
std::string background_of(const ReportSources& sources, std::size_t limit) {
  if (!sources.surface) return "";
  if (limit > 0) return "<use href=\"#relief\"/>\n";
  const std::optional<Overview> overview =
      relief_overview(*sources.surface, sources.map->sites, sources.map->sensor.height_m);
  return overview ? relief_image(*overview) : "";
}

// How a picture of the route is coloured: "range" or "look", and the colour of each.
struct RouteColours {
  std::string by;
  std::string (*colour_of)(std::size_t) = nullptr;
};

// A dashed line along the sites whose poses scans do not constrain; empty where there are none.
std::string unconstrained_svg(const CompiledMap& map, double width_m) {
  const auto column = std::ranges::find(map.columns, "unconstrained", &SiteColumn::name);
  if (column == map.columns.end()) return "";
  const std::vector<Site>& sites = map.sites.sites;
  std::string path;
  bool goes_on = false;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const bool is_open = column->values[i] > 0.0F;
    goes_on = goes_on && i > 0 && sites[i].run == sites[i - 1].run;
    if (is_open) {
      path += fmt::format("{}{:.2f} {:.2f}", goes_on ? "L" : "M", sites[i].p_map_m.x(),
                          -sites[i].p_map_m.y());
    }
    goes_on = is_open;
  }
  return fmt::format(
      "<path d=\"{}\" style=\"fill:none;stroke:currentColor;stroke-width:{:.2f};"
      "stroke-dasharray:{:.2f}\"/>\n",
      path, 0.4 * width_m, 1.5 * width_m);
}

// The route from above at one limit, over a background in SVG.
std::string still_route(const CompiledMap& map, const RangeTable& choice, std::size_t limit,
                        const RouteColours& colours, const std::string& background) {
  const Sites& sites = map.sites;
  const MapBox box = box_of_route(sites, kMargin_m);
  const double route_m = std::max(box.width_m(), box.height_m()) / 150.0;
  return concat(
      fmt::format(R"(<svg class="still-map" role="img" viewBox="{:.2f} {:.2f} {:.2f} {:.2f}">)"
                  "<title>The route from above, coloured by {}</title>\n",
                  box.low_x_m, -box.high_y_m, box.width_m(), box.height_m(), colours.by),
      background, route_svg(sites, choice, limit, route_m, colours.colour_of),
      unconstrained_svg(map, route_m), scale_bar_svg(box, "currentColor"), "</svg>\n");
}

// How often each look is chosen that any site takes, with its colour.
std::string shares(const RangeTable& looks, std::size_t limit) {
  std::vector<std::size_t> counts(looks.looks.size(), 0);
  for (std::size_t site = 0; site < looks.site_count; ++site) ++counts[looks.range(site, limit)];
  std::string html = "<div class=\"legend\">";
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const double share = static_cast<double>(counts[i]) / static_cast<double>(looks.site_count);
    html += concat("<span><i style=\"background:", look_colour(i), "\"></i>",
                   to_text(looks.looks[i]), ": ", percent(share), "</span> ");
  }
  return html + "</div>\n";
}

std::string choice_at(const CompiledMap& map, std::size_t limit) {
  const RangeTable& looks = map.looks->ranges;
  const std::string limit_words = limit_text(looks.promises[limit].limit_m);
  const std::string id = concat("looks-", limit);
  return concat(
      "<h3>Limit ", limit_words, "</h3>\n",
      paragraph("Expected within " + limit_words + ": " +
                percent(map.looks->quality[limit].expected_coverage) + " of the sites."),
      html_figure(
          {id, "Looks, " + limit_words + ".",
           "The look chosen at each place, and the share of the sites for each "
           "look, in order of matching time.",
           still_route(map, looks, limit, {"look", &look_colour}, "") + shares(looks, limit), ""}));
}

std::string words_of(LookRule rule) {
  switch (rule) {
    case LookRule::kMap:
      return "this map";
    case LookRule::kSameEverywhere:
      return "best static look, with the map's normals";
    case LookRule::kSameWithoutMap:
      return "best static look, without a map";
    case LookRule::kOracle:
      return "oracle (ideal case)";
  }
  return "";
}

std::string judged(const LookEvaluation& evaluation) {
  TextGrid rules = {{"limit", "rule", "coverage (%)", "time ratio", "work ratio"}};
  for (const LookRuleScore& score : evaluation.rules) {
    if (score.rule == LookRule::kSameWithoutMap && !evaluation.has_baselines) continue;
    rules.push_back({limit_text(score.limit_m), words_of(score.rule), in_percent(score.coverage),
                     fixed(score.time_ratio, 3), fixed(score.work_ratio, 3)});
  }
  TextGrid statics = {{"look"}};
  for (const double limit_m : evaluation.limits_m) {
    statics.front().push_back(concat("within ", limit_text(limit_m), " (%)"));
  }
  statics.front().insert(statics.front().end(), {"time ratio", "work ratio"});
  for (const StaticLook& look : evaluation.statics) {
    std::vector<std::string>& row = statics.emplace_back();
    row.push_back(to_text(look.look));
    for (const double coverage : look.coverage) row.push_back(in_percent(coverage));
    row.push_back(fixed(look.time_ratio, 3));
    row.push_back(fixed(look.work_ratio, 3));
  }
  return html_table(rules,
                    "Looks on the judging drive. Ratios: time and work relative to the longest "
                    "range; static looks are compared at the coverage of this map") +
         html_table(statics, "One look everywhere: possible without an annotated map");
}

}  // namespace

// The counterpart of the paper's Figure 11: the map from above, the route coloured by range.
Section map_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"map", "The map", ""};
  Figure figure = {"figure-11", "The map from above.", "", "", "map"};
  figure.caption = page_script().empty()
                       ? "Observation range at each place, seen from above (+y of the map is up)."
                       : "+y of the map is up. A printed page shows the observation range at each "
                         "place.";
  if (sources.surface) {
    figure.caption +=
        " Grey: surfaces seen by the mapping drive, darker where higher above the road.";
  }
  if (map.trajectory && !map.trajectory->unconstrained.empty()) {
    figure.caption += " Dashed: scans do not constrain the poses of the map.";
  }
  if (!page_script().empty()) {
    figure.caption +=
        " Point at the route to read the answer, click it to see its reason. The "
        "wheel zooms once the map was clicked.";
  }
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    figure.picture_html +=
        concat("<h3>Limit ", limit_text(map.ranges.promises[limit].limit_m), "</h3>\n",
               still_route(map, map.ranges, limit, {"range", &range_colour},
                           background_of(sources, limit)),
               legend(map));
  }
  section.html = html_figure(figure);
  return section;
}

// The look with the least matching time at each place, compared with one look everywhere.
Section looks_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"looks", "Looks: range and scan sample", ""};
  if (map.looks) {
    section.html = paragraph(
        "A look is a range and the sample of a scan that is matched within it. The observation "
        "range is how far a vehicle must see; the look is the smallest part of the scan that is "
        "sufficient.");
    for (std::size_t limit = 0; limit < map.looks->ranges.promises.size(); ++limit) {
      section.html += choice_at(map, limit);
    }
  }
  if (sources.evaluation && sources.evaluation->samples) {
    section.html += judged(*sources.evaluation->samples);
  }
  return section;
}

}  // namespace sightline
