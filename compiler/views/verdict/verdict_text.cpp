#include "compiler/views/verdict/verdict_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "formats/base/printable.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

// Colours that every reader of Markdown shows.
const char* sign_of(MapVerdict verdict) {
  static constexpr const char* kSigns[] = {"\U0001F7E2", "\U0001F7E1", "\U0001F534", "\u26AA"};
  return kSigns[static_cast<std::size_t>(verdict)];
}

std::string_view name_of(Evidence evidence) {
  static constexpr std::string_view kNames[] = {"none", "own-drive", "evaluation"};
  return kNames[static_cast<std::size_t>(evidence)];
}

Json lost_of(const std::optional<std::uint32_t>& count) { return count ? Json(*count) : Json(); }

Json fixed_json(const ConstantScore& constant) {
  return {{"look", constant.look},
          {"coverage", constant.coverage},
          {"time_ratio", constant.time_ratio},
          {"work_ratio", constant.work_ratio},
          {"lost_count", lost_of(constant.lost_count)}};
}

Json limit_json(const LimitVerdict& limit) {
  Json json = {{"limit_m", limit.limit_m},
               {"verdict", word_of(limit.verdict)},
               {"recommended", name_of(limit.recommended)},
               {"target", limit.target},
               {"answered_share", limit.answered_share},
               {"recommended_share", limit.recommended_share},
               {"expected_coverage", limit.expected_coverage},
               {"longest_unmet_m", limit.unmet_m},
               {"reason", limit.reason},
               {"score", nullptr},
               {"best_fixed", nullptr},
               {"same_work_fixed", nullptr}};
  if (limit.score) {
    json["score"] = {{"of", name_of(limit.score->kind)},
                     {"coverage", limit.score->coverage},
                     {"answered_coverage", limit.score->answered_coverage},
                     {"time_ratio", limit.constant ? Json(limit.score->time_ratio) : Json()},
                     {"work_ratio", limit.constant ? Json(limit.score->work_ratio) : Json()},
                     {"lost_count", lost_of(limit.score->lost_count)}};
  }
  if (limit.constant) json["best_fixed"] = fixed_json(*limit.constant);
  if (limit.same_work) json["same_work_fixed"] = fixed_json(*limit.same_work);
  return json;
}

bool is_unit(const std::string& word) {
  static constexpr std::string_view kUnits[] = {"%", "m", "cm", "km", "s"};
  return std::ranges::any_of(kUnits, [&](std::string_view unit) {
    return word.starts_with(unit) &&
           (word.size() == unit.size() ||
            std::string_view(",;.:)").find(word[unit.size()]) != std::string_view::npos);
  });
}

// The words of a text, a number with its unit as one.
std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    if (words.empty() || !is_unit(word)) {
      words.push_back(word);
    } else {
      words.back() += " " + word;
    }
  }
  return words;
}

std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

// Where the last clause outside brackets begins; npos: there is only one clause.
std::size_t last_clause(const std::string& text) {
  std::size_t last = std::string::npos;
  int depth = 0;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (depth == 0 && text.compare(i, 2, "; ") == 0) last = i;
  }
  return last;
}

// Without what its first brackets hold.
std::string without_brackets(std::string text) {
  const std::size_t begin = text.find(" (");
  const std::size_t end = text.find(')', begin == std::string::npos ? text.size() : begin);
  if (end != std::string::npos) text.erase(begin, end + 1 - begin);
  return text;
}

std::string without_last_sentence(const std::string& text) {
  const std::size_t end = text.rfind(". ");
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

// As many clauses of the promise as fit on so many lines; the whole is in `inspect --all` and JSON.
std::string shortened(const std::string& promise, std::size_t most = 2) {
  std::string text = promise;
  while (line_count(wrapped(text)) > most) {
    const std::size_t end = last_clause(text);
    std::string shorter =
        end == std::string::npos ? without_brackets(text) : text.substr(0, end) + ".";
    if (shorter.size() >= text.size()) shorter = without_last_sentence(text);
    if (shorter.size() >= text.size()) break;
    text = std::move(shorter);
  }
  return text;
}

}  // namespace

std::string verdict_head(const MapJudgement& judgement) {
  return concat("Verdict: ", word_of(judgement.verdict));
}

std::string verdict_rest(const MapJudgement& judgement) {
  std::string text = ".";
  if (!judgement.reason.empty()) text += " " + judgement.reason;
  if (!judgement.figures.empty()) text += " " + judgement.figures;
  return text;
}

std::string to_text(const MapJudgement& judgement) {
  std::string text = wrapped(verdict_head(judgement) + verdict_rest(judgement));
  // With the next command at most five lines.
  const std::size_t most = line_count(text) > 2 ? 1 : 2;
  if (!judgement.promise.empty()) text += wrapped(shortened(judgement.promise, most));
  return text + "Next: " + judgement.next + "\n";
}

std::string to_markdown(const MapJudgement& judgement) {
  std::string text =
      concat("**Verdict: ", sign_of(judgement.verdict), " ", word_of(judgement.verdict), "**",
             markdown_text(verdict_rest(judgement)));
  if (!judgement.promise.empty()) text += " " + markdown_text(shortened(judgement.promise));
  return text + "\n";
}

Json to_json(const MapJudgement& judgement) {
  Json json = {{"word", word_of(judgement.verdict)},
               {"colour", colour_of(judgement.verdict)},
               {"evidence", name_of(judgement.evidence)},
               {"drive", judgement.drive},
               {"is_own_drive", judgement.is_own_drive},
               {"drive_role", name_of(judgement.origin)},
               {"judged_count", judgement.judged_count},
               {"judged", judgement.is_replayed ? "scans" : "sites"},
               {"reason", judgement.reason},
               {"figures", judgement.figures},
               {"promise", judgement.promise},
               {"next", judgement.next},
               {"limits", Json::array()}};
  for (const LimitVerdict& limit : judgement.limits) json["limits"].push_back(limit_json(limit));
  return json;
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::string all;
  std::string line;
  for (const std::string& word : words_of(printable(text))) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      all += line + "\n";
      line = std::string(indent, ' ') + word;
      continue;
    }
    line += line.empty() ? word : " " + word;
  }
  return line.empty() ? all : all + line + "\n";
}

}  // namespace sightline
