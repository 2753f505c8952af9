#include "compiler/views/report/route.h"
#include "compiler/views/report/sections/sections.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

std::string tile(const std::string& value, const std::string& unit, const std::string& what) {
  return "<div class=\"tile\"><div class=\"value\">" + xml_text(value) + "<span class=\"unit\"> " +
         xml_text(unit) + "</span></div><div class=\"what\">" + xml_text(what) + "</div></div>\n";
}

std::string tiles_of_map(const CompiledMap& map) {
  const std::vector<double> route_m = route_of_sites_m(map.sites);
  return tile(fixed(route_m.empty() ? 0.0 : route_m.back(), 0), "m",
              "of route, " + std::to_string(map.sites.sites.size()) + " sites") +
         tile(std::to_string(map.ndt.nds.size()), "NDs",
              "of " + metres(map.ndt.cell_m) + ", from " + std::to_string(map.ndt.point_count) +
                  " points");
}

std::string tiles_of_limit(const ReportSources& sources, std::size_t limit) {
  const std::string limit_words = limit_text(sources.map->ranges.promises[limit].limit_m);
  const LimitQuality& quality = sources.map->quality[limit];
  std::string html = tile(fixed(quality.mean_range_m, 1), "m", "mean range for " + limit_words);
  if (!sources.evaluation) {
    return html + tile(percent(quality.expected_coverage), "%", "expected within " + limit_words);
  }
  const RuleScore& score = sources.evaluation->score(limit, Rule::kMap);
  return html + tile(percent(score.coverage), "%", "of judged sites within " + limit_words) +
         tile(fixed(score.time_ratio, 2), "×",
              "the matching time of always looking " +
                  metres(sources.evaluation->statics.back().range_m));
}

}  // namespace

Section summary_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"summary", "At a glance", ""};
  section.html = "<div class=\"tiles\">\n" + tiles_of_map(map);
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    section.html += tiles_of_limit(sources, limit);
  }
  section.html += "</div>\n";
  return section;
}

}  // namespace sightline
