#include "compiler/views/report/report.h"

#include <algorithm>
#include <cctype>

#include "compiler/views/report/page/packed.h"
#include "compiler/views/report/page/page_assets.h"
#include "compiler/views/report/page/page_data.h"
#include "compiler/views/report/sections/sections.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

Result<void> check_sources(const ReportSources& sources) {
  const std::size_t sites = sources.map->sites.sites.size();
  const bool has_sites =
      sites > 0 && sources.map->quality.size() == sources.map->ranges.promises.size();
  const bool is_judged = !sources.evaluation ||
                         (sources.evaluation->site_count == sites &&
                          sources.evaluation->limits_m == sources.map->predicted.limits_m &&
                          sources.evaluation->statics.size() == sources.map->ranges.looks.size());
  const bool is_measured = !sources.measured || sources.measured->scan_of_site.size() == sites;
  const bool is_seen = !sources.depth || sources.depth->site_count == sites;
  const bool is_gated =
      !sources.gate || sources.gate->root_digest == to_hex(sources.summary.root_digest);
  if (has_sites && is_judged && is_measured && is_seen && is_gated) return {};
  return Error{
      ErrorCode::kMismatchedInputs,
      concat(
          "measurements, evaluation, depth images and gate result must be of this map, with its ",
          sites, " sites, ranges and limits; make them again for this map"),
      sources.map_file};
}

// A map may be stripped of its factors, or older than virtual scans.
bool has_virtual_points(const CompiledMap& map) {
  const std::vector<std::string>& factors = map.factors.factors;
  return std::find(factors.begin(), factors.end(), "virtual_points") != factors.end();
}

Result<std::vector<Section>> sections_of(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  std::vector<Section> all = {summary_section(sources)};
  if (sources.diff) all.push_back(diff_section(sources));
  all.push_back(map_section(sources));
  if (map.looks) all.push_back(looks_section(sources));
  if (sources.evaluation) {
    all.push_back(ranges_section(*sources.evaluation, map.sites));
    all.push_back(ideal_section(*sources.evaluation, map.sites));
    all.push_back(choice_section(*sources.evaluation, map.sites));
  }
  if (sources.weakness) all.push_back(weak_section(*sources.weakness, map.sites));
  if (sources.tracks) all.push_back(tracks_section(*sources.tracks));
  all.push_back(trust_section(sources));
  if (sources.measured && has_virtual_points(map)) {
    SIGHTLINE_ASSIGN(const FactorReport factors, factor_report(map.factors, *sources.measured));
    all.push_back(factors_section(factors, map));
  }
  all.push_back(making_section(sources));
  for (const auto& make : {passes_section, provenance_section}) {
    SIGHTLINE_ASSIGN(Section section, make(sources));
    all.push_back(std::move(section));
  }
  return all;
}

// The drive that mapped is what people know a map by; its id is a digest unless they chose one.
std::string title_of(const CompiledMap& map) {
  const std::string& drive = map.measurement.mapping_drive;
  return drive.empty() ? map.map_id : drive;
}

std::string kind_of(const ReportSources& sources) {
  if (!sources.diff) return "sightline map report";
  return concat("sightline change report: ", sources.map_file, " against ", sources.old_map_file);
}

// The sections' ids as words: short enough to stand in one row.
std::string link_to(const Section& section) {
  std::string word = section.id;
  word.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(word.front())));
  return concat("<li><a href=\"#", section.id, "\" title=\"", xml_text(section.title), "\">", word,
                "</a></li>\n");
}

std::string header(const ReportSources& sources, const std::vector<Section>& all) {
  const CompiledMap& map = *sources.map;
  std::string html =
      concat("<header>\n<p class=\"kind\">", xml_text(kind_of(sources)), "</p>\n<h1>",
             xml_text(title_of(map)), "</h1>\n",
             paragraph("Map " + map.map_id + ", version " + map.version + ", release " +
                       std::to_string(map.release) +
                       ". Which part of a scan a vehicle needs to localize itself at each place."));
  if (page_script().empty()) {
    html += paragraph(
        "This program was built without the scripts of the page: its pictures are static.");
  }
  html += "</header>\n<nav aria-label=\"Contents\"><ul>\n";
  for (const Section& section : all) html += link_to(section);
  return html + "</ul></nav>\n";
}

std::string section_html(const Section& section) {
  return concat("<section id=\"", section.id, "\">\n<h2>", xml_text(section.title), "</h2>\n",
                section.html, "</section>\n");
}

bool is_on_first_screen(const Section& section) {
  return section.id == "summary" || section.id == "map";
}

// The verdict and the map, side by side where the window is wide.
std::string first_screen(const std::vector<Section>& all) {
  std::string html = "<div class=\"first-screen\">\n";
  for (const Section& section : all) {
    if (is_on_first_screen(section)) html += section_html(section);
  }
  return html + "</div>\n";
}

}  // namespace

bool has_page_scripts() { return !page_script().empty(); }

Result<std::string> report_html(const ReportSources& sources) {
  SIGHTLINE_TRY(check_sources(sources));
  SIGHTLINE_ASSIGN(const std::vector<Section> all, sections_of(sources));
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      // Nothing is fetched, whatever texts a map contains.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: "
      "blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n<title>" +
      xml_text(title_of(*sources.map)) + " – sightline report</title>\n<style>\n" +
      std::string(page_style()) + colours_css(*sources.map) + std::string(library_style()) +
      "</style>\n</head>\n<body>\n" + header(sources, all) + "<main>\n";
  html += first_screen(all);
  for (const Section& section : all) {
    if (!is_on_first_screen(section)) html += section_html(section);
  }
  html += "</main>\n";
  if (!page_script().empty()) {
    html += concat("<script type=\"application/json\" id=\"data\">", page_data_json(sources),
                   "</script>\n<script type=\"text/plain\" id=\"scene\">", packed(scene_script()),
                   "</script>\n<script>\n", page_script(), "</script>\n");
  }
  return html + "</body>\n</html>\n";
}

}  // namespace sightline
