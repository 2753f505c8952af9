#include "compiler/views/report/page/page_answers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "compiler/views/text/describe_protection.h"
#include "formats/model/place_kind.h"

namespace sightline {
namespace {

PageJson looks_json(const LooksOfMap& looks) {
  const RangeTable& table = looks.ranges;
  std::vector<std::string> texts;
  for (const Look& look : table.looks) texts.push_back(to_text(look));
  std::vector<float> probability;
  std::vector<float> mean_m;  // of the error
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t limit = 0; limit < table.promises.size(); ++limit) {
      const std::size_t look = table.range(site, limit);
      probability.push_back(static_cast<float>(looks.predicted.probability(site, look, limit)));
      mean_m.push_back(static_cast<float>(looks.predicted.mean(site, look)));
    }
  }
  return {{"texts", texts},
          {"index", json_numbers(table.range_index)},
          {"flags", json_numbers(table.flags)},
          {"probability", json_numbers(probability)},
          {"mean_m", json_numbers(mean_m)}};
}

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
  PageJson json = {{"recommended", recommended}};
  if (!map.looks) return json;
  json["looks"] = looks_json(*map.looks);
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
