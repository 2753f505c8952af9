#include "compiler/gate/rules/map_figures.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

auto virtual_points(const CompiledMap& map) {
  return std::ranges::find(map.factors.factors, "virtual_points");
}

// Sites [begin, end) of one run that all have a value.
struct Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
};

template <class HasValue>
std::vector<Piece> pieces_of(const Sites& sites, const HasValue& has_value) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    if (!has_value(i)) continue;
    const bool continues =
        !pieces.empty() && pieces.back().end == i && sites.sites[i - 1].run == sites.sites[i].run;
    if (continues) {
      ++pieces.back().end;
    } else {
      pieces.push_back({i, i + 1});
    }
  }
  return pieces;
}

bool is_worse(double a, double b, Bound bound) { return bound == Bound::kAtMost ? a > b : a < b; }

// Calls `see(first, last, mean)` for every window of the piece, ascending.
template <class See>
void each_window(const Sites& sites, const std::vector<double>& value, const Piece& piece,
                 double length_m, const See& see) {
  // Sums are taken anew from a running total: the same for every order of calls.
  std::vector<double> total = {0.0};
  for (std::size_t i = piece.begin; i < piece.end; ++i) total.push_back(total.back() + value[i]);
  // A millionth of a metre: sites stand at whole metres but for rounding.
  constexpr double kSlack_m = 1e-6;
  std::size_t last = piece.begin;
  for (std::size_t first = piece.begin; first < piece.end; ++first) {
    const double end_m = sites.sites[first].s_m + length_m + kSlack_m;
    while (last + 1 < piece.end && sites.sites[last + 1].s_m <= end_m) ++last;
    const auto count = static_cast<double>(last + 1 - first);
    see(first, last, (total[last + 1 - piece.begin] - total[first - piece.begin]) / count);
    if (last + 1 == piece.end) return;  // what follows is part of this window
  }
}

void cut_back(const std::vector<double>& value, Bound bound, double allowed, BadStretch& stretch) {
  while (stretch.first < stretch.last && is_within(value[stretch.first], bound, allowed)) {
    ++stretch.first;
  }
  while (stretch.last > stretch.first && is_within(value[stretch.last], bound, allowed)) {
    --stretch.last;
  }
}

}  // namespace

double share_of_sites(const CompiledMap& map, std::uint32_t count) {
  return static_cast<double>(count) / static_cast<double>(map.ranges.site_count);
}

double p95_range_m(const CompiledMap& map, std::size_t limit) {
  std::vector<double> ranges_m;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    ranges_m.push_back(map.ranges.range_m(site, limit));
  }
  std::ranges::sort(ranges_m);
  const auto needed =
      static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(ranges_m.size())));
  return ranges_m[needed - 1];
}

bool has_virtual_points(const CompiledMap& map) {
  return virtual_points(map) != map.factors.factors.end();
}

double expected_work(const CompiledMap& map, std::size_t limit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!has_virtual_points(map)) return kNone;
  const auto column = static_cast<std::size_t>(virtual_points(map) - map.factors.factors.begin());
  std::vector<double> at_chosen;
  std::vector<double> at_longest;
  const std::size_t longest = map.ranges.looks.size() - 1;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    at_chosen.push_back(map.factors.at(site, map.ranges.range(site, limit), column));
    at_longest.push_back(map.factors.at(site, longest, column));
  }
  const double whole = ordered_sum(at_longest);
  return whole > 0.0 ? ordered_sum(at_chosen) / whole : kNone;
}

double chosen_probability(const CompiledMap& map, std::size_t site, std::size_t limit) {
  return map.predicted.probability(site, map.ranges.range(site, limit), limit);
}

std::vector<bool> unmet_sites(const CompiledMap& map, std::size_t limit) {
  std::vector<bool> is_unmet;
  for (std::size_t site = 0; site < map.ranges.site_count; ++site) {
    is_unmet.push_back((map.ranges.flags_of(site, limit) & kUnmet) != 0);
  }
  return is_unmet;
}

RouteStretch stretch_between(const Sites& sites, std::size_t first, std::size_t last) {
  const Site& middle = sites.sites[first + (last - first) / 2];
  RouteStretch stretch;
  stretch.first_site = static_cast<std::uint32_t>(first);
  stretch.last_site = static_cast<std::uint32_t>(last);
  stretch.run = sites.sites[first].run;
  stretch.first_s_m = sites.sites[first].s_m;
  stretch.last_s_m = sites.sites[last].s_m;
  stretch.middle_map_m = middle.p_map_m;
  stretch.middle_world_m = sites.frame.world_m(middle.p_map_m);
  return stretch;
}

std::string in_words(const RouteStretch& stretch) {
  const Eigen::Vector3d& p_m = stretch.middle_world_m;
  return fmt::format(
      "{}sites {} to {} (run {}, {:.0f} to {:.0f} m, around ({:.1f}, {:.1f}, {:.1f}) m in the "
      "world)",
      stretch.is_of_old ? "the old map's " : "", stretch.first_site, stretch.last_site, stretch.run,
      stretch.first_s_m, stretch.last_s_m, p_m.x(), p_m.y(), p_m.z());
}

std::vector<BadStretch> bad_stretches(const Sites& sites, const std::vector<double>& value,
                                      const StretchSearch& search, double allowed) {
  std::vector<BadStretch> found;
  const auto see = [&](std::size_t first, std::size_t last, double mean) {
    if (is_within(mean, search.bound, allowed)) return;
    const bool touches = !found.empty() && first <= found.back().last + 1 &&
                         sites.sites[found.back().last].run == sites.sites[first].run;
    if (!touches) {
      found.push_back({first, last, mean, first, last});
      return;
    }
    BadStretch& stretch = found.back();
    stretch.last = last;
    if (!is_worse(mean, stretch.worst, search.bound)) return;
    stretch.worst = mean;
    stretch.worst_first = first;
    stretch.worst_last = last;
  };
  for (const Piece& piece :
       pieces_of(sites, [&](std::size_t i) { return !std::isnan(value[i]); })) {
    each_window(sites, value, piece, search.length_m, see);
  }
  for (BadStretch& stretch : found) cut_back(value, search.bound, allowed, stretch);
  return found;
}

BadStretch worst_stretch(const Sites& sites, const std::vector<double>& value,
                         const StretchSearch& search) {
  BadStretch worst{1, 0, 0.0, 1, 0};
  const auto see = [&](std::size_t first, std::size_t last, double mean) {
    if (worst.last >= worst.first && !is_worse(mean, worst.worst, search.bound)) return;
    worst = {first, last, mean, first, last};
  };
  for (const Piece& piece :
       pieces_of(sites, [&](std::size_t i) { return !std::isnan(value[i]); })) {
    each_window(sites, value, piece, search.length_m, see);
  }
  return worst;
}

std::vector<BadStretch> bad_or_worst(const Sites& sites, const std::vector<double>& value,
                                     const StretchSearch& search, std::optional<double> allowed) {
  std::vector<BadStretch> bad;
  if (allowed) bad = bad_stretches(sites, value, search, *allowed);
  if (bad.empty()) bad.push_back(worst_stretch(sites, value, search));
  return bad;
}

std::vector<LongStretch> long_stretches(const Sites& sites, const std::vector<bool>& is_bad) {
  std::vector<LongStretch> found;
  for (const Piece& piece : pieces_of(sites, [&](std::size_t i) { return is_bad[i]; })) {
    found.push_back({piece.begin, piece.end - 1,
                     sites.sites[piece.end - 1].s_m - sites.sites[piece.begin].s_m});
  }
  return found;
}

}  // namespace sightline
