#include "compiler/views/exports/site_properties.h"

#include <algorithm>

namespace sightline {
namespace {

using Properties = std::vector<std::pair<std::string, SiteProperty>>;

std::string within(const CompiledMap& map, std::size_t limit) {
  return "_within_" + format_double(map.ranges.promises[limit].limit_m) + "_m";
}

void add_look(const CompiledMap& map, std::size_t site, std::size_t limit, Properties& properties) {
  const RangeTable& looks = map.ranges.of_samples.front();
  const std::size_t look = looks.range(site, limit);
  const std::string suffix = within(map, limit);
  properties.emplace_back("look" + suffix, to_text(looks.looks[look]));
  properties.emplace_back("look_p" + suffix,
                          map.predicted.of_samples.front().probability(site, look, limit));
  properties.emplace_back("look_static" + suffix, (looks.flags_of(site, limit) & kStatic) != 0);
}

}  // namespace

std::string range_property(const CompiledMap& map, std::size_t limit) {
  return "range_m" + within(map, limit);
}

Properties site_properties(const CompiledMap& map, std::size_t site) {
  const Site& at = map.sites.sites[site];
  Properties properties = {
      {"site", static_cast<std::int64_t>(site)}, {"run", std::int64_t{at.run}}, {"s_m", at.s_m}};
  // The same columns at all places of a map.
  const bool is_annotated = std::ranges::find(map.definitions, "annotating-a-finished-map",
                                              &NamedVersion::name) != map.definitions.end();
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    const std::string suffix = within(map, limit);
    const std::size_t range = map.ranges.range(site, limit);
    const std::uint8_t flags = map.ranges.flags_of(site, limit);
    properties.emplace_back("range_m" + suffix, map.ranges.looks[range].range_m);
    properties.emplace_back("p" + suffix, map.predicted.probability(site, range, limit));
    properties.emplace_back("error_m" + suffix, map.predicted.mean(site, range));
    properties.emplace_back("unmet" + suffix, (flags & kUnmet) != 0);
    properties.emplace_back("extrapolated" + suffix, (flags & kExtrapolated) != 0);
    properties.emplace_back("static" + suffix, (flags & kStatic) != 0);
    if (is_annotated) {
      properties.emplace_back("simulated" + suffix, (flags & kSimulatedAnswer) != 0);
    }
    if (!map.ranges.of_samples.empty()) add_look(map, site, limit, properties);
  }
  for (const SiteColumn& column : map.columns) {
    properties.emplace_back(column.name, double{column.values[site]});
  }
  return properties;
}

}  // namespace sightline
