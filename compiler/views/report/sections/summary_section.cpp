#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

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

// The look that most sites take at a limit, and their share.
std::pair<std::size_t, double> most_frequent_look(const RangeTable& looks, std::size_t limit) {
  std::vector<std::size_t> counts(looks.looks.size(), 0);
  for (std::size_t site = 0; site < looks.site_count; ++site) ++counts[looks.range(site, limit)];
  const auto most = std::ranges::max_element(counts);
  const auto sites = static_cast<double>(std::max(looks.site_count, 1U));
  return {static_cast<std::size_t>(most - counts.begin()), static_cast<double>(*most) / sites};
}

// What a vehicle is advised to use within a limit.
std::string recommended_tile(const CompiledMap& map, const LimitVerdict& limit, std::size_t index) {
  const std::string recommended = "recommended within " + limit_text(limit.limit_m);
  if (limit.recommended == AnswerKind::kRange) {
    return tile(fixed(map.quality[index].mean_range_m, 1), "m",
                concat(recommended, ": the range; its mean"));
  }
  const RangeTable& looks = map.looks->ranges;
  if (limit.recommended == AnswerKind::kPlan) {
    return tile("plan", "",
                concat(recommended, ": ", to_text(looks.plan->first),
                       "; a larger look where a test rejects the result"));
  }
  const auto [look, share] = most_frequent_look(looks, index);
  return tile("look", "",
              concat(recommended, ": ", to_text(looks.looks[look]), " at ", percent(share),
                     " of the places"));
}

std::string tiles_of_limit(const CompiledMap& map, const LimitVerdict& limit, std::size_t index) {
  const std::string html = recommended_tile(map, limit, index);
  if (!limit.score || !(limit.score->time_ratio > 0.0)) return html;
  return html + tile(fixed(limit.score->time_ratio, 2), "×",
                     concat("the matching time of always looking ",
                            metres(map.ranges.looks.back().range_m), ", by ",
                            name_of(limit.score->kind), " within ", limit_text(limit.limit_m)));
}

}  // namespace

Section summary_section(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  const MapJudgement judgement = judge_map(map, sources.figures, {});
  Section section = {"summary", "Verdict", overall(judgement) + "<div class=\"verdicts\">\n"};
  if (sources.gate) section.html += gate_card(*sources.gate);
  for (std::size_t limit = 0; limit < judgement.limits.size(); ++limit) {
    section.html += limit_card(map, judgement, limit);
  }
  section.html += "</div>\n<div class=\"tiles\">\n" + tiles_of_map(map);
  for (std::size_t limit = 0; limit < judgement.limits.size(); ++limit) {
    section.html += tiles_of_limit(map, judgement.limits[limit], limit);
  }
  section.html += "</div>\n";
  return section;
}

}  // namespace sightline
