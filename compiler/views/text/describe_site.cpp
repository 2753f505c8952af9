#include "compiler/views/text/describe_site.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "compiler/views/text/describe_protection.h"
#include "formats/annotation/range_rule.h"
#include "formats/model/place_kind.h"

namespace sightline {
namespace {

constexpr double kFarOff = 2.0;  // robust z from which a factor is listed
constexpr std::size_t kMostTold = 6;

std::string at_range(double range_m) { return fmt::format("{:g} m", range_m); }

std::string describe_place(const CompiledMap& map, std::size_t id) {
  const Site& site = map.sites.sites[id];
  const Eigen::Vector3d p_m = map.sites.frame.world_m(site.p_map_m);
  return fmt::format(
      "site {}, run {}, {:.1f} m from its start, at ({:.2f}, {:.2f}, {:.2f}) m in the world\n", id,
      site.run, site.s_m, p_m.x(), p_m.y(), p_m.z());
}

std::string describe_prediction(const CompiledMap& map, std::size_t site) {
  std::string text = fmt::format("  {:22}", "range, m");
  for (const Look& look : map.ranges.looks) text += fmt::format(" {:>7g}", look.range_m);
  text += fmt::format("\n  {:22}", "predicted error, cm");
  for (std::size_t range = 0; range < map.ranges.looks.size(); ++range) {
    text += fmt::format(" {:>7.1f}", 100.0 * map.predicted.mean(site, range));
  }
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    text += fmt::format("\n  P(error <= {:.4g} m)     ", map.ranges.promises[limit].limit_m);
    for (std::size_t range = 0; range < map.ranges.looks.size(); ++range) {
      text += fmt::format(" {:>7.3f}", map.predicted.probability(site, range, limit));
    }
  }
  return text + "\n";
}

std::size_t chosen_range(const CompiledMap& map, std::size_t site, std::size_t limit) {
  return map.ranges.range(site, limit);
}

double apart_m(const CompiledMap& map, std::size_t a, std::size_t b) {
  return std::abs(map.sites.sites[a].s_m - map.sites.sites[b].s_m);
}

// The nearest other site of the same run, up to `most_m` away, that `is_wanted`; of two as near the
// one further back. Sites lie ascending by (run, s_m).
template <class IsWanted>
std::optional<std::size_t> nearest_along(const CompiledMap& map, std::size_t site, double most_m,
                                         IsWanted is_wanted) {
  const std::vector<Site>& sites = map.sites.sites;
  const auto is_there = [&](std::size_t i) {
    return i < sites.size() && sites[i].run == sites[site].run && apart_m(map, site, i) <= most_m;
  };
  std::size_t back = site - 1;  // of site 0: past the end
  std::size_t ahead = site + 1;
  while (is_there(back) || is_there(ahead)) {
    const bool is_back = is_there(back) && (!is_there(ahead) ||
                                            apart_m(map, site, back) <= apart_m(map, site, ahead));
    const std::size_t other = is_back ? back-- : ahead++;
    if (is_wanted(other)) return other;
  }
  return std::nullopt;
}

// What the site's own predictions ask for.
std::string describe_own(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const LimitPromise& promise = map.ranges.promises[limit];
  const double p = map.predicted.has_history[site] == 1 ? promise.history_threshold
                                                        : promise.probability_threshold;
  const std::optional<std::size_t> own = own_range(map.ranges, map.predicted, site, limit);
  const std::string needed = map.ranges.selection == Selection::kMean
                                 ? "a predicted error within the limit"
                                 : fmt::format("p* = {:.3f}", p);
  return own ? concat("    shortest range with ", needed, ": ",
                      at_range(map.ranges.looks[*own].range_m), "\n")
             : concat("    no range has ", needed, "\n");
}

std::string_view words_of_static(Reason reason) {
  if (reason == Reason::kSimulation) return "from the simulation at this site";
  if (reason == Reason::kDrives)
    return "one range for all driven sites, each drive predicted by the others";
  return "one range for the street, from the map's own scans";
}

// The range that this site would have alone, and what made another of it.
std::string describe_reason(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const std::uint8_t flags = map.ranges.flags_of(site, limit);
  const Reason reason = map.ranges.reason(site, limit);
  const std::optional<std::size_t> own = own_range(map.ranges, map.predicted, site, limit);
  const std::size_t chosen = chosen_range(map, site, limit);
  std::string text = describe_own(map, site, limit);
  if ((flags & kStatic) != 0) {
    text += concat("    static: ", words_of_static(reason), ", not from the model\n");
  }
  if ((flags & kSimulatedAnswer) != 0) {
    text += "    simulated: no scan was recorded here, only simulated ones\n";
  }
  if ((flags & kUnmet) != 0) text += "    unmet: no range is good enough; this one is the best\n";
  if ((flags & kExtrapolated) != 0) {
    text += "    extrapolated: the place is unlike those that the model was trained on\n";
  }
  if (reason == Reason::kTighterLimit) {
    return text + "    shorter: it is enough for the next tighter limit\n";
  }
  if (!own || *own == chosen || (flags & (kUnmet | kExtrapolated | kStatic)) != 0) return text;
  const auto asks_for_more = [&](std::size_t other) {
    return own_range(map.ranges, map.predicted, other, limit).value_or(chosen) >= chosen;
  };
  const std::optional<std::size_t> other =
      nearest_along(map, site, map.ranges.dilation_m, asks_for_more);
  if (other) {
    return text + fmt::format("    longer because of site {}, {:.1f} m away\n", *other,
                              apart_m(map, site, *other));
  }
  return text + "    longer because of a neighbouring site\n";
}

std::string describe_better(const CompiledMap& map, std::size_t site, std::size_t limit) {
  const auto does_with_less = [&](std::size_t other) {
    return chosen_range(map, other, limit) < chosen_range(map, site, limit);
  };
  const std::optional<std::size_t> other =
      nearest_along(map, site, std::numeric_limits<double>::infinity(), does_with_less);
  if (!other) return "    no site of this run has a shorter range\n";
  const bool is_ahead = map.sites.sites[*other].s_m > map.sites.sites[site].s_m;
  return fmt::format("    nearest site with a shorter range: {}, {:.1f} m {}, {:g} m\n", *other,
                     apart_m(map, site, *other), is_ahead ? "further on" : "back",
                     map.ranges.range_m(*other, limit));
}

std::string describe_choice(const CompiledMap& map, std::size_t site, std::size_t limit) {
  return fmt::format("  within {:g} m: range {:g} m\n", map.ranges.promises[limit].limit_m,
                     map.ranges.range_m(site, limit)) +
         fmt::format("    reason: {}\n", name_of(map.ranges.reason(site, limit))) +
         describe_reason(map, site, limit) + describe_better(map, site, limit);
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct FarOff {
  std::size_t factor = 0;
  double value = 0.0;
  double median = 0.0;
  double z = 0.0;
};

std::optional<FarOff> far_off(const FactorTable& factors, const RouteFactors& route,
                              std::size_t site, std::size_t range, std::size_t factor) {
  const std::size_t cell = range * factors.factors.size() + factor;
  FarOff found{factor, factors.at(site, range, factor), route.median[cell], 0.0};
  found.z = robust_z(found.value, found.median, route.deviation[cell]);
  if (std::abs(found.z) < kFarOff) return std::nullopt;
  return found;
}

std::optional<std::size_t> column_of(const FactorTable& factors, std::string_view name) {
  const auto found = std::find(factors.factors.begin(), factors.factors.end(), name);
  if (found == factors.factors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - factors.factors.begin());
}

std::string describe_factors(const CompiledMap& map, const RouteFactors& route, std::size_t site,
                             std::size_t range) {
  const std::optional<std::size_t> heading = column_of(map.factors, "crlb_heading");
  std::vector<FarOff> found;
  for (std::size_t factor = 0; factor < map.factors.factors.size(); ++factor) {
    if (factor == heading) continue;  // a direction has no median
    const std::optional<FarOff> one = far_off(map.factors, route, site, range, factor);
    if (one) found.push_back(*one);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const FarOff& a, const FarOff& b) { return std::abs(a.z) > std::abs(b.z); });
  if (found.size() > kMostTold) found.resize(kMostTold);
  const std::string where = at_range(map.ranges.looks[range].range_m);
  if (found.empty()) return concat("  at ", where, " no factor is far from the route's median\n");
  std::string text = concat("  far from the route's median at ", where, "\n");
  for (const FarOff& one : found) {
    text += fmt::format("    {:18} {:>10.4g}   median {:>10.4g}   z {:+.1f}\n",
                        map.factors.factors[one.factor], one.value, one.median, one.z);
  }
  return text;
}

std::string describe_weakness(const CompiledMap& map, std::size_t site, std::size_t range) {
  const std::optional<std::size_t> heading = column_of(map.factors, "crlb_heading");
  const std::optional<std::size_t> weak = column_of(map.factors, "crlb_max");
  const std::optional<std::size_t> strong = column_of(map.factors, "crlb_min");
  if (!heading || !weak || !strong) return "";
  const double heading_deg = map.factors.at(site, range, *heading);
  const double off_deg = off_road_deg(map.sites.sites[site], heading_deg);
  return fmt::format(
      "  weakest {}: {:.0f} degrees from +x, {:.0f} off the road; {:.1f} times the strongest "
      "direction's uncertainty\n",
      name_of_way(off_deg), heading_deg, off_deg,
      map.factors.at(site, range, *weak) / map.factors.at(site, range, *strong));
}

// Nothing where the map has no looks that take a sample.
std::string describe_look(const CompiledMap& map, std::size_t site, std::size_t limit) {
  if (!map.looks) return "";
  const Answer look = answer_of(map.looks->ranges, map.looks->predicted, site, limit);
  return fmt::format("    look: {}\n      P {:.1f} %, predicted error {:.1f} cm{}; reason: {}\n",
                     to_text(look.look), 100.0 * look.probability, 100.0 * look.error_m,
                     (look.flags & kStatic) != 0 ? "; one look for the whole map" : "",
                     name_of(look.reason));
}

std::string describe_columns(const CompiledMap& map, std::size_t site) {
  std::string text;
  for (const SiteColumn& column : map.columns) {
    if (column.name == kPlaceKindColumn) {
      text += concat("  kind of place: ", name_of(kind_at(map.columns, site)), "\n");
      continue;
    }
    text += concat("  ", column.name, " ", format_double(double{column.values[site]}),
                   (column.unit.empty() ? "" : " " + column.unit), "\n");
  }
  return text;
}

}  // namespace

RouteFactors route_factors(const FactorTable& factors) {
  RouteFactors route;
  std::vector<double> values(factors.site_count);
  for (std::size_t range = 0; factors.site_count > 0 && range < factors.looks.size(); ++range) {
    for (std::size_t factor = 0; factor < factors.factors.size(); ++factor) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = factors.at(i, range, factor);
      const double median = median_of(values);
      for (double& value : values) value = std::abs(value - median);
      route.median.push_back(median);
      route.deviation.push_back(median_of(values));
    }
  }
  return route;
}

double robust_z(double value, double median, double deviation) {
  constexpr double kSigmaPerDeviation = 0.6745;  // of a normal distribution
  return deviation > 0.0 ? kSigmaPerDeviation * (value - median) / deviation : 0.0;
}

Result<std::string> describe_site(const CompiledMap& map, std::size_t site) {
  return describe_site(map, route_factors(map.factors), site);
}

Result<std::string> describe_site(const CompiledMap& map, const RouteFactors& route,
                                  std::size_t site) {
  if (site >= map.sites.sites.size()) {
    return Error{ErrorCode::kBadArgument,
                 fmt::format("found site {}, expected 0 to {}", site, map.sites.sites.size() - 1)};
  }
  std::string text =
      describe_place(map, site) + describe_columns(map, site) + describe_protection(map, site);
  text += describe_prediction(map, site);
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    text += describe_choice(map, site, limit);
    text += describe_look(map, site, limit);
  }
  if (map.factors.factors.empty()) return text + "  this map has no factors\n";
  // What the strictest limit had to look through.
  const std::size_t range = chosen_range(map, site, 0);
  std::vector<std::size_t> described = {0};
  if (range != 0) described.push_back(range);
  for (const std::size_t each : described) {
    text += describe_factors(map, route, site, each) + describe_weakness(map, site, each);
  }
  return text;
}

}  // namespace sightline
