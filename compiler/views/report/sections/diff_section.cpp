#include <fmt/format.h>

#include <cmath>

#include "compiler/views/report/sections/sections.h"

namespace sightline {
namespace {

constexpr std::size_t kMostStretches = 200;  // shown in the page; `sightline diff` lists them all

// "town.slmap: map 25a1, version 1, release 1, b0aad14757b2"
std::string name_of(const std::string& file, const DiffedMap& map) {
  return fmt::format("{}: map {}, version {}, release {}, {:.12}", file, map.map_id, map.version,
                     map.release, to_hex(map.root_digest));
}

// "+3.0", "−3.0", "0.0" as it is shown.
std::string signed_text(double number, int decimals) {
  const std::string text = fixed(std::abs(number), decimals);
  const bool is_zero = text.find_first_not_of("0.") == std::string::npos;
  return (is_zero ? "" : number > 0.0 ? "+" : "−") + text;
}

// One number of a limit before and after, where each map has the limit.
struct LimitNumber {
  const char* name;
  double (*value)(const LimitQuality& quality);
  int decimals;
};

constexpr LimitNumber kLimitNumbers[] = {
    {"mean range (m)", [](const LimitQuality& quality) { return quality.mean_range_m; }, 1},
    {"expected within the limit (%)",
     [](const LimitQuality& quality) { return 100.0 * quality.expected_coverage; }, 1},
    {"unmet sites", [](const LimitQuality& quality) { return double(quality.unmet_count); }, 0}};

std::vector<std::string> number_row(const LimitDiff& limit, const LimitNumber& number) {
  const auto cell = [&](const std::optional<LimitQuality>& quality) -> std::string {
    return quality ? fixed(number.value(*quality), number.decimals) : "–";
  };
  const std::string difference =
      limit.is_common()
          ? signed_text(number.value(*limit.after) - number.value(*limit.before), number.decimals)
          : "–";
  return {concat(limit_text(limit.limit_m), ", ", number.name), cell(limit.before),
          cell(limit.after), difference};
}

std::string limits_table(const MapDiff& diff) {
  TextGrid grid = {{"for a limit of", "before", "after", "difference"}};
  Facts sites;
  for (const LimitDiff& limit : diff.limits) {
    for (const LimitNumber& number : kLimitNumbers) grid.push_back(number_row(limit, number));
    if (!limit.is_common()) continue;
    sites.emplace_back(
        "sites at " + limit_text(limit.limit_m),
        fmt::format(
            "{} with a longer range, {} with a shorter one, {} newly unmet, {} no longer unmet",
            limit.rose, limit.fell, limit.newly_unmet, limit.no_longer_unmet));
  }
  return html_table(grid, "Answers of the map, before and after") + fact_table(sites);
}

std::string link_to_site(const Stretch& stretch) {
  const std::string sites = fmt::format("{} to {}", stretch.first_site, stretch.last_site);
  if (stretch.is_of_old_map) return sites + " of the old map";
  return concat("<a href=\"#site=", stretch.first_site, "\">", sites, "</a>");
}

std::string stretch_row(const Stretch& stretch) {
  std::string html =
      fmt::format("<tr><th scope=\"row\">{}</th><td>{}, {:.0f} to {:.0f}</td><td>{} / {} / {}</td>",
                  link_to_site(stretch), stretch.run, stretch.begin_s_m, stretch.end_s_m,
                  stretch.nds_added, stretch.nds_removed, stretch.nds_moved);
  for (const StretchLimit& limit : stretch.limits) {
    if (stretch.is_new() || stretch.is_of_old_map) {
      html += fmt::format("<td>{}</td><td>–</td><td>–</td>", stretch.is_new() ? "new" : "removed");
      continue;
    }
    html += fmt::format("<td>{:.1f} → {:.1f}</td><td>{}</td><td>{}</td>", limit.mean_range_before_m,
                        limit.mean_range_after_m,
                        signed_text(limit.mean_range_after_m - limit.mean_range_before_m, 1),
                        limit.newly_unmet);
  }
  return html + "</tr>\n";
}

std::string stretches_table(const MapDiff& diff) {
  if (diff.stretches.empty()) return paragraph("No stretch of the route differs.");
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\"><table id=\"stretches\"><caption>Stretches of route "
      "that changed</caption>\n<thead><tr><th scope=\"col\">sites</th>"
      "<th scope=\"col\">run, distance (m)</th><th scope=\"col\">NDs added / removed / moved</th>";
  for (const double limit_m : common_limits_m(diff)) {
    html += fmt::format(
        "<th scope=\"col\">mean range for {0} (m)</th><th scope=\"col\">difference (m)</th>"
        "<th scope=\"col\">newly unmet for {0}</th>",
        limit_text(limit_m));
  }
  html += "</tr></thead><tbody>\n";
  const std::size_t shown = std::min(diff.stretches.size(), kMostStretches);
  for (std::size_t i = 0; i < shown; ++i) html += stretch_row(diff.stretches[i]);
  html += "</tbody></table></div>\n";
  if (shown == diff.stretches.size()) return html;
  return html +
         paragraph(fmt::format("The first {} of {} stretches; sightline diff lists the others.",
                               shown, diff.stretches.size()));
}

std::string facts_table(const MapDiff& diff) {
  if (diff.facts.empty()) return "";
  TextGrid grid = {{"property", "before", "after"}};
  for (const FactDiff& fact : diff.facts) grid.push_back({fact.name, fact.before, fact.after});
  return concat("<details><summary>Properties that differ</summary>\n",
                html_table(grid, "Properties of the map as a whole"), "</details>\n");
}

}  // namespace

Section diff_section(const ReportSources& sources) {
  const MapDiff& diff = *sources.diff;
  Section section = {"diff", "Changes from the older map", ""};
  section.html = fact_table({{"before", name_of(sources.old_map_file, diff.before)},
                             {"after", name_of(sources.map_file, diff.after)}});
  if (diff.is_same()) {
    section.html += paragraph("Both maps are equal.");
    return section;
  }
  section.html +=
      limits_table(diff) +
      fact_table(
          {{"sites", fmt::format("{} added, {} removed", diff.sites_added, diff.sites_removed)},
           {"NDs", diff.has_comparable_nds
                       ? fmt::format("{} added, {} removed, {} moved by more than {} cm",
                                     diff.nds_added, diff.nds_removed, diff.nds_moved,
                                     in_centimetres(diff.options.tolerance_m))
                       : std::string("not compared: the cell sizes differ")},
           {"tiles", fmt::format("{} changed, {} added, {} removed", diff.tiles_changed,
                                 diff.tiles_added, diff.tiles_removed)}}) +
      stretches_table(diff) + facts_table(diff);
  return section;
}

}  // namespace sightline
