#include <fmt/format.h>

#include <algorithm>

#include "compiler/views/report/page/page_data.h"
#include "compiler/views/report/sections/sections.h"
#include "formats/text/quoted_text.h"

// The first screen: for each limit what is promised and what came of it, then what the gate said.

namespace sightline {
namespace {

constexpr std::size_t kMostViolations = 8;  // shown; the gate lists them all

enum class Sign { kGood, kOpen, kBad };

// Words say it too: the colour alone never does.
std::string status(Sign sign, const std::string& words) {
  const char* name = sign == Sign::kGood ? "good" : sign == Sign::kBad ? "bad" : "open";
  return concat("<p class=\"status is-", name, "\">", xml_text(words), "</p>\n");
}

std::string card(const std::string& title, const std::string& html) {
  return concat("<div class=\"verdict\">\n<h3>", xml_text(title), "</h3>\n", html, "</div>\n");
}

std::string promise_status(const CompiledMap& map, const LimitPromise& promise) {
  if (promise.is_earned) {
    return status(Sign::kGood, concat("Promised: at least ", in_percent(1.0 - promise.alpha),
                                      " % of the next drive"));
  }
  if (map.measurement.reference == ErrorReference::kSimulated) {
    return status(Sign::kOpen, "No promise: no drive was here, errors were simulated");
  }
  return status(Sign::kOpen, promise.scope == PromiseScope::kNextDrive
                                 ? "No promise: it was not earned"
                                 : "No promise: learned from this drive alone");
}

std::string asked_words(const LimitPromise& promise) {
  return promise.alpha > 0.0 ? concat("; asked: ", in_percent(1.0 - promise.alpha), " %") : "";
}

// "96.7 % of 151 judged sites; asked: 95.0 %", and whether that is enough.
std::string share_status(const ReportSources& sources, std::size_t limit) {
  const LimitPromise& promise = sources.map->ranges.promises[limit];
  const std::string within = " within " + limit_text(promise.limit_m);
  const auto not_judged = [&](const std::string& share) {
    return status(Sign::kOpen, concat(share, " of the sites", asked_words(promise),
                                      ". No drive has judged the map here"));
  };
  if (!sources.evaluation) {
    const double expected = sources.map->quality[limit].expected_coverage;
    return not_judged(concat("Expected", within, ": ", in_percent(expected), " %"));
  }
  const double coverage = sources.evaluation->score(limit, Rule::kMap).coverage;
  if (sources.evaluation->reference == ErrorReference::kSimulated) {
    return not_judged(concat("In simulation", within, ": ", percent(coverage)));
  }
  const bool is_enough = coverage >= 1.0 - promise.alpha;
  return status(is_enough ? Sign::kGood : Sign::kBad,
                fmt::format("{}: {} % of {} judged sites{}{}",
                            is_enough ? "Reached" : "Not reached", in_percent(coverage),
                            sources.evaluation->sites.size(), within, asked_words(promise)));
}

// Of the map's own rules at this limit: "the map's range 0, the map's look 1".
std::string lost_status(const DriveTracks& tracks, double limit_m) {
  std::uint32_t most = 0;
  std::string words;
  for (std::size_t rule = 0; rule < tracks.rules.size(); ++rule) {
    const TrackRule& each = tracks.rules[rule];
    if (each.is_static() || !is_judged_at(each, limit_m)) continue;
    const std::uint32_t lost = score_track(tracks, rule, limit_m).lost_count;
    most = std::max(most, lost);
    words += concat((words.empty() ? "" : ", "), name_of(each), " ", lost);
  }
  if (words.empty()) return "";
  return status(most == 0 ? Sign::kGood : Sign::kBad,
                concat("Tracks lost over ", tracks.scans.size(), " scans: ", words));
}

std::string limit_card(const ReportSources& sources, std::size_t limit) {
  const LimitPromise& promise = sources.map->ranges.promises[limit];
  std::string html = promise_status(*sources.map, promise) + share_status(sources, limit);
  if (sources.tracks) html += lost_status(*sources.tracks, promise.limit_m);
  if (!promise.statement.empty()) {
    html += concat("<p class=\"why\">", xml_text(promise.statement), "</p>\n");
  }
  return card("Within " + limit_text(promise.limit_m), html);
}

std::string violations_of(const GateResult& gate) {
  std::string html;
  const std::size_t shown = std::min(gate.violations.size(), kMostViolations);
  for (std::size_t i = 0; i < shown; ++i) {
    const GateResult::Violation& each = gate.violations[i];
    html += "<li>" + xml_text(concat(each.severity, ", ", each.rule, ": ", each.message));
    if (each.first_site) {
      const std::string site = std::to_string(*each.first_site);
      html += concat(" (<a href=\"#site=", site, "\">site ", site, "</a>)");
    }
    html += "</li>\n";
  }
  if (shown < gate.violations.size()) {
    html += concat("<li>and ", gate.violations.size() - shown, " more</li>\n");
  }
  if (html.empty()) return "";
  return concat("<details><summary>Rules that are violated</summary>\n<ul class=\"why\">\n", html,
                "</ul></details>\n");
}

std::string gate_card(const GateResult& gate) {
  const std::string counts = fmt::format("{} errors, {} warnings, {} notes, {} excepted",
                                         gate.errors, gate.warnings, gate.notes, gate.excepted);
  return card("Gate", status(gate.passed ? Sign::kGood : Sign::kBad,
                             (gate.passed ? "Passed: " : "Failed: ") + counts) +
                          violations_of(gate));
}

std::string tile(const std::string& value, const std::string& unit, const std::string& what) {
  return fmt::format(R"(<div class="tile"><div class="value">{}<span class="unit"> {}</span></div>)"
                     "<div class=\"what\">{}</div></div>\n",
                     xml_text(value), xml_text(unit), xml_text(what));
}

std::string tiles_of_map(const CompiledMap& map) {
  const std::vector<double> route_m = route_of_sites_m(map.sites);
  return tile(fixed(route_m.empty() ? 0.0 : route_m.back(), 0), "m",
              concat("of route, ", map.sites.sites.size(), " sites")) +
         tile(std::to_string(map.ndt.nds.size()), "NDs",
              fmt::format("of {}, from {} points", metres(map.ndt.cell_m), map.ndt.point_count));
}

std::string tiles_of_limit(const ReportSources& sources, std::size_t limit) {
  const std::string limit_words = limit_text(sources.map->ranges.promises[limit].limit_m);
  std::string html = tile(fixed(sources.map->quality[limit].mean_range_m, 1), "m",
                          "mean range for " + limit_words);
  if (!sources.evaluation) return html;
  return html + tile(fixed(sources.evaluation->score(limit, Rule::kMap).time_ratio, 2), "×",
                     fmt::format("the matching time of always looking {}, for {}",
                                 metres(sources.evaluation->statics.back().range_m), limit_words));
}

}  // namespace

Section summary_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  Section section = {"summary", "Verdict", "<div class=\"verdicts\">\n"};
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    section.html += limit_card(sources, limit);
  }
  if (sources.gate) section.html += gate_card(*sources.gate);
  section.html += "</div>\n<div class=\"tiles\">\n" + tiles_of_map(map);
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    section.html += tiles_of_limit(sources, limit);
  }
  section.html += "</div>\n";
  return section;
}

}  // namespace sightline
