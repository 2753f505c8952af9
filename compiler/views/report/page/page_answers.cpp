#include "compiler/views/report/page/page_answers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "compiler/views/text/describe_protection.h"
#include "compiler/views/verdict/recommended_answer.h"
#include "formats/model/place_kind.h"

namespace sightline {
namespace {

constexpr std::uint8_t kNoGoodAnswer = 3;  // behind the kinds of answer

// [site][axis]: forward, left and up, m. Empty unless a site of the map has all three.
std::vector<float> protection_m(const CompiledMap& map) {
  std::vector<float> levels_m;
  bool has_any = false;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    const SiteProtection found = protection_at(map, site);
    bool has_all = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      levels_m.push_back(static_cast<float>(found.levels[axis]));
      has_all = has_all && std::isfinite(found.levels[axis]);
    }
    has_any = has_any || has_all;
  }
  return has_any ? levels_m : std::vector<float>();
}

}  // namespace

PageJson answers_json(const CompiledMap& map, const MapJudgement& judgement) {
  std::vector<std::string_view> recommended;
  for (const LimitVerdict& limit : judgement.limits) {
    recommended.push_back(kNamesOf<AnswerKind>[static_cast<std::size_t>(limit.recommended)]);
  }
  std::vector<std::uint8_t> kinds;
  std::vector<std::uint8_t> choices;
  std::vector<float> mean_m;  // of the error
  std::vector<float> probability;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    for (std::size_t limit = 0; limit < judgement.limits.size(); ++limit) {
      const RecommendedAnswer answer =
          recommended_answer(map, judgement.limits[limit].recommended, site, limit);
      kinds.push_back(answer.is_good ? static_cast<std::uint8_t>(answer.kind) : kNoGoodAnswer);
      choices.push_back(static_cast<std::uint8_t>(answer.choice));
      mean_m.push_back(static_cast<float>(answer.mean_error_m));
      probability.push_back(static_cast<float>(answer.probability));
    }
  }
  PageJson json = {{"recommended", recommended},
                   {"kind", json_numbers(kinds)},
                   {"choice", json_numbers(choices)},
                   {"mean_m", json_numbers(mean_m)},
                   {"probability", json_numbers(probability)}};
  if (!map.looks) return json;
  std::vector<std::string> looks;
  for (const Look& look : map.looks->ranges.looks) looks.push_back(to_text(look));
  json["looks"] = looks;
  json["looks_range_m"] = ranges_of(map.looks->ranges.looks);
  if (map.looks->ranges.plan) json["plan"] = to_text(*map.looks->ranges.plan);
  return json;
}

PageJson places_json(const CompiledMap& map) {
  PageJson json = PageJson::object();
  const bool has_kinds =
      std::ranges::find(map.columns, kPlaceKindColumn, &SiteColumn::name) != map.columns.end();
  if (!has_kinds) return json;
  std::vector<std::uint8_t> kinds;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    kinds.push_back(static_cast<std::uint8_t>(kind_at(map.columns, site)));
  }
  json["kinds"] = kNamesOf<PlaceKind>;
  json["kind"] = json_numbers(kinds);
  const std::vector<float> levels_m = protection_m(map);
  if (!levels_m.empty()) {
    json["risk"] = kShownRisk;
    json["protection_m"] = json_numbers(levels_m);
  }
  return json;
}

}  // namespace sightline
