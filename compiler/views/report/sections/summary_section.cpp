#include <fmt/format.h>

#include <algorithm>

#include "compiler/views/report/page/page_data.h"
#include "compiler/views/report/sections/sections.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/text/quoted_text.h"

// The first screen: the verdict, what it is made of at each limit, and the result of the gate.

namespace sightline {
namespace {

constexpr std::size_t kMostViolations = 8;  // shown; the gate lists them all

// The style of each verdict; words say it too: the colour alone never does.
std::string style_of(MapVerdict verdict) {
  static constexpr const char* kStyles[] = {"is-good", "is-partly", "is-bad", "is-not-judged"};
  return kStyles[static_cast<std::size_t>(verdict)];
}

std::string status(MapVerdict verdict, const std::string& words) {
  return concat("<p class=\"status ", style_of(verdict), "\">", xml_text(words), "</p>\n");
}

std::string why(const std::string& text) {
  return text.empty() ? "" : concat("<p class=\"why\">", xml_text(text), "</p>\n");
}

std::string card(const std::string& title, const std::string& html) {
  return concat("<div class=\"verdict\">\n<h3>", xml_text(title), "</h3>\n", html, "</div>\n");
}

// The verdict on the map in the words that every verb prints.
std::string overall(const MapJudgement& judgement) {
  std::string sentences = judgement.reason;
  if (!sentences.empty() && !judgement.figures.empty()) sentences += " ";
  return concat("<div class=\"overall ", style_of(judgement.verdict), "\">\n<p class=\"word\">",
                verdict_head(judgement), "</p>\n<p>", xml_text(sentences + judgement.figures),
                "</p>\n", why(judgement.promise), "</div>\n");
}

std::string share_status(const MapJudgement& judgement, const LimitVerdict& limit) {
  if (!limit.score) {
    return status(MapVerdict::kNotJudged,
                  concat("Predicted: ", percent(limit.expected_coverage), " of the places"));
  }
  return status(limit.verdict,
                concat("By ", name_of(limit.score->kind), ": ", percent(limit.score->coverage),
                       " of ", judgement.judged_count, judgement.is_replayed ? " scans" : " places",
                       judgement.is_own_drive ? " of its own drive" : "",
                       "; target: ", percent(limit.target)));
}

std::string lost_status(const LimitVerdict& limit) {
  if (!limit.score || !limit.score->lost_count) return "";
  const std::uint32_t lost = *limit.score->lost_count;
  const std::uint32_t least = limit.constant ? limit.constant->lost_count.value_or(0) : 0;
  return status(lost > least ? MapVerdict::kBad : MapVerdict::kGood,
                concat("Tracks lost: ", lost, "; best fixed choice: ", least));
}

std::string answered_status(const LimitVerdict& limit) {
  const bool is_enough = limit.answered_share >= VerdictThresholds::kLeastAnswered &&
                         limit.unmet_m < VerdictThresholds::kUnmetStretch_m;
  return status(is_enough ? MapVerdict::kGood : MapVerdict::kPartly,
                concat(percent(limit.answered_share), " of the places have an answer"));
}

std::string promise_status(const LimitPromise& promise) {
  if (!promise.is_earned) return status(MapVerdict::kNotJudged, "No promise for the next drive");
  return status(MapVerdict::kGood, concat("Promised: at least ", percent(1.0 - promise.alpha),
                                          " of the answered sites of the next drive"));
}

std::string limit_card(const CompiledMap& map, const MapJudgement& judgement, std::size_t index) {
  const LimitVerdict& limit = judgement.limits[index];
  const bool goes_by_looks = map.looks && limit.recommended != AnswerKind::kRange;
  const LimitPromise& promise = (goes_by_looks ? map.looks->ranges : map.ranges).promises[index];
  return card("Within " + limit_text(limit.limit_m),
              share_status(judgement, limit) + lost_status(limit) + answered_status(limit) +
                  promise_status(promise));
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
  return card("Gate", status(gate.passed ? MapVerdict::kGood : MapVerdict::kBad,
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
  const MapJudgement judgement = judge_map(map, sources.figures, {});
  Section section = {"summary", "Verdict", overall(judgement) + "<div class=\"verdicts\">\n"};
  for (std::size_t limit = 0; limit < judgement.limits.size(); ++limit) {
    section.html += limit_card(map, judgement, limit);
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
