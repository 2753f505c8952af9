#include <cmath>

#include "compiler/views/report/sections/sections.h"

// What changed against an older map.

namespace sightline {
namespace {

constexpr std::size_t kMostStretches = 200;  // shown in the page; `sightline diff` tells them all

std::string name_of(const DiffedMap& map) {
  return map.version + ", release " + std::to_string(map.release) + ", " +
         to_hex(map.root_digest).substr(0, 12);
}

std::string limits_table(const MapDiff& diff) {
  TextGrid grid = {{"limit", "mean range before (m)", "after (m)", "expected coverage before (%)",
                    "after (%)", "unmet sites before", "after", "sites that look farther",
                    "less far", "newly unmet", "no longer unmet"}};
  for (const LimitDiff& limit : diff.limits) {
    const auto cell = [](const std::optional<LimitQuality>& quality, auto text_of) {
      return quality ? text_of(*quality) : std::string("–");
    };
    const auto range = [](const LimitQuality& quality) { return fixed(quality.mean_range_m, 1); };
    const auto coverage = [](const LimitQuality& quality) {
      return percent(quality.expected_coverage);
    };
    const auto unmet = [](const LimitQuality& quality) {
      return std::to_string(quality.unmet_count);
    };
    grid.push_back({limit_text(limit.limit_m), cell(limit.before, range), cell(limit.after, range),
                    cell(limit.before, coverage), cell(limit.after, coverage),
                    cell(limit.before, unmet), cell(limit.after, unmet), std::to_string(limit.rose),
                    std::to_string(limit.fell), std::to_string(limit.newly_unmet),
                    std::to_string(limit.no_longer_unmet)});
  }
  return html_table(grid, "What a vehicle is told, before and after");
}

std::string link_to_site(const Stretch& stretch) {
  const std::string sites =
      std::to_string(stretch.first_site) + " to " + std::to_string(stretch.last_site);
  if (stretch.is_of_old_map) return sites + " of the old map";
  return "<a href=\"#site=" + std::to_string(stretch.first_site) + "\">" + sites + "</a>";
}

std::string stretch_row(const Stretch& stretch) {
  std::string html = "<tr><th scope=\"row\">" + link_to_site(stretch) + "</th><td>" +
                     std::to_string(stretch.run) + ", " + fixed(stretch.begin_s_m, 0) + " to " +
                     fixed(stretch.end_s_m, 0) + "</td><td>" + std::to_string(stretch.nds_added) +
                     " / " + std::to_string(stretch.nds_removed) + " / " +
                     std::to_string(stretch.nds_moved) + "</td>";
  for (const StretchLimit& limit : stretch.limits) {
    html += "<td>" + fixed(limit.mean_range_before_m, 1) + " → " +
            fixed(limit.mean_range_after_m, 1) + "</td><td>" + std::to_string(limit.newly_unmet) +
            "</td>";
  }
  return html + "</tr>\n";
}

std::string stretches_table(const MapDiff& diff) {
  if (diff.stretches.empty()) return paragraph("No stretch of the route differs.");
  std::string html =
      "<div class=\"scroll\"><table id=\"stretches\"><caption>Stretches of route where something "
      "changed</caption>\n<thead><tr><th scope=\"col\">sites</th><th scope=\"col\">run, way "
      "(m)</th>"
      "<th scope=\"col\">NDs added / removed / moved</th>";
  for (const double limit_m : common_limits_m(diff)) {
    html += "<th scope=\"col\">mean range for " + limit_text(limit_m) +
            " (m)</th><th scope=\"col\">newly unmet for " + limit_text(limit_m) + "</th>";
  }
  html += "</tr></thead><tbody>\n";
  const std::size_t shown = std::min(diff.stretches.size(), kMostStretches);
  for (std::size_t i = 0; i < shown; ++i) html += stretch_row(diff.stretches[i]);
  html += "</tbody></table></div>\n";
  if (shown == diff.stretches.size()) return html;
  return html + paragraph("The first " + std::to_string(shown) + " of " +
                          std::to_string(diff.stretches.size()) +
                          " stretches; sightline diff tells the others.");
}

std::string facts_table(const MapDiff& diff) {
  if (diff.facts.empty()) return "";
  TextGrid grid = {{"property", "before", "after"}};
  for (const FactDiff& fact : diff.facts) grid.push_back({fact.name, fact.before, fact.after});
  return "<details><summary>Properties that differ</summary>\n" +
         html_table(grid, "Properties of the map as a whole") + "</details>\n";
}

}  // namespace

Section diff_section(const MapDiff& diff) {
  Section section = {"diff", "Against the older map", ""};
  section.html = fact_table({{"before", name_of(diff.before)}, {"after", name_of(diff.after)}});
  if (diff.is_same()) {
    section.html += paragraph("Both maps say the same.");
    return section;
  }
  section.html +=
      limits_table(diff) +
      fact_table({{"sites", std::to_string(diff.sites_added) + " added, " +
                                std::to_string(diff.sites_removed) + " removed"},
                  {"NDs", diff.has_comparable_nds
                              ? std::to_string(diff.nds_added) + " added, " +
                                    std::to_string(diff.nds_removed) + " removed, " +
                                    std::to_string(diff.nds_moved) + " moved by more than " +
                                    centimetres(diff.options.tolerance_m) + " cm"
                              : std::string("of other cells, which do not compare")},
                  {"tiles", std::to_string(diff.tiles_changed) + " changed, " +
                                std::to_string(diff.tiles_added) + " added, " +
                                std::to_string(diff.tiles_removed) + " removed"}}) +
      stretches_table(diff) + facts_table(diff);
  return section;
}

}  // namespace sightline
