#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "compiler/gate/rules/map_figures.h"
#include "compiler/gate/rules/rules.h"
#include "formats/text/numbers.h"

// One map: how well it is annotated, and how its poses were made.

namespace sightline {
namespace {

constexpr LimitFigure kMeasuredCoverage = {
    "coverage on the localization drive", "share",
    [](const CompiledMap& map, std::size_t limit) { return map.quality[limit].measured_coverage; }};
constexpr LimitFigure kP95Range = {"the range that covers 95 % of the sites", "m", &p95_range_m};

constexpr const char* kNoGivenSharpness = "the map has no sharpness with the given poses";

// One finding for each limit of the map.
template <const LimitFigure& kFigure>
std::vector<Found> at_limits(const GateInput& input, const Threshold&) {
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < input.map->ranges.promises.size(); ++limit) {
    const double limit_m = input.map->ranges.promises[limit].limit_m;
    const double number = kFigure.of(*input.map, limit);
    found.push_back(
        {limit_m, std::nullopt, number,
         fmt::format("{}{} is {}", kFigure.what, within(limit_m), in_words(number, kFigure.unit))});
  }
  return found;
}

std::vector<Found> find_promise(const GateInput& input, const Threshold&) {
  std::vector<Found> found;
  for (const LimitPromise& promise : input.map->ranges.promises) {
    const double value = promise.is_earned ? 1.0 : 0.0;
    found.push_back({promise.limit_m, std::nullopt, value,
                     concat(within(promise.limit_m).substr(1), ": ", promise.statement)});
  }
  return found;
}

std::vector<Found> find_measured_coverage(const GateInput& input, const Threshold& threshold) {
  if (input.map->measurement.measured_site_count == 0) {
    return not_judged("no drive was measured in this map");
  }
  return at_limits<kMeasuredCoverage>(input, threshold);
}

std::vector<Found> find_measured_sites(const GateInput& input, const Threshold&) {
  const double share = share_of_sites(*input.map, input.map->measurement.measured_site_count);
  return of_whole_map(share, concat("errors were measured at ", percent(share), " of the sites"));
}

std::vector<Found> find_expected_work(const GateInput& input, const Threshold& threshold) {
  if (!has_virtual_points(*input.map)) {
    return not_judged("the map has no factor virtual_points, from which work is predicted");
  }
  return at_limits<kExpectedWork>(input, threshold);
}

std::vector<Found> find_worst_stretch(const GateInput& input, const Threshold& threshold) {
  const Sites& sites = input.map->sites;
  const StretchSearch search{input.stretch_m, Bound::kAtLeast};
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < input.map->ranges.promises.size(); ++limit) {
    const double limit_m = input.map->ranges.promises[limit].limit_m;
    std::vector<double> value;
    for (std::size_t site = 0; site < input.map->ranges.site_count; ++site) {
      value.push_back(chosen_probability(*input.map, site, limit));
    }
    for (const BadStretch& bad : bad_or_worst(sites, value, search, threshold.at(limit_m))) {
      const RouteStretch place = stretch_between(sites, bad.first, bad.last);
      found.push_back({limit_m, place, bad.worst,
                       fmt::format("{}: expected coverage{} is {} over the worst {} m of route",
                                   in_words(place), within(limit_m), percent(bad.worst),
                                   format_double(input.stretch_m))});
    }
  }
  return found;
}

std::vector<Found> find_unmet_stretch(const GateInput& input, const Threshold& threshold) {
  std::vector<Found> found;
  for (std::size_t limit = 0; limit < input.map->ranges.promises.size(); ++limit) {
    const double limit_m = input.map->ranges.promises[limit].limit_m;
    std::vector<LongStretch> stretches =
        long_stretches(input.map->sites, unmet_sites(*input.map, limit));
    const auto add = [&](const LongStretch& stretch) {
      const RouteStretch place = stretch_between(input.map->sites, stretch.first, stretch.last);
      found.push_back({limit_m, place, stretch.length_m,
                       concat(in_words(place), ": no range is good enough", within(limit_m),
                              " for ", in_words(stretch.length_m, "m"), " of route")});
    };
    const double allowed = threshold.at(limit_m).value_or(std::numeric_limits<double>::infinity());
    const std::size_t before = found.size();
    for (const LongStretch& stretch : stretches) {
      if (stretch.length_m > allowed) add(stretch);
    }
    if (found.size() > before) continue;
    const auto longest = std::ranges::max_element(stretches, {}, &LongStretch::length_m);
    if (longest != stretches.end()) {
      add(*longest);
    } else {
      found.push_back({limit_m, std::nullopt, 0.0,
                       concat("some range is good enough", within(limit_m), " at every site")});
    }
  }
  return found;
}

std::vector<Found> find_model_r_squared(const GateInput& input, const Threshold&) {
  const double mean = input.map->model.mean_r_squared;
  return of_whole_map(mean, concat("the model's cross-validated R^2 is ", in_words(mean, ""),
                                   ", the mean over ranges"));
}

std::vector<Found> find_plane_thickness(const GateInput& input, const Threshold&) {
  if (!input.map->sharpness) return not_judged("the map has no sharpness");
  const double thickness_m = std::sqrt(input.map->sharpness->of_map.mean_plane_variance_m2);
  return of_whole_map(thickness_m,
                      fmt::format("planes of the map are {} thick (standard deviation)",
                                  in_words(thickness_m, "m")));
}

std::vector<Found> find_less_sharp_than_given(const GateInput& input, const Threshold&) {
  const auto& sharpness = input.map->sharpness;
  if (!sharpness || !sharpness->of_given) return not_judged(kNoGivenSharpness);
  const double loss_nat =
      sharpness->of_map.mean_entropy_nat - sharpness->of_given->mean_entropy_nat;
  return of_whole_map(
      loss_nat, fmt::format("the mean entropy of the map is {} above that with the given poses",
                            in_words(loss_nat, "nat")));
}

// A building that appears twice has an entropy like one that appears once; its walls are thicker.
std::vector<Found> find_thicker_than_given(const GateInput& input, const Threshold&) {
  const auto& sharpness = input.map->sharpness;
  if (!sharpness || !sharpness->of_given) return not_judged(kNoGivenSharpness);
  const double thicker_m = std::sqrt(sharpness->of_map.mean_plane_variance_m2) -
                           std::sqrt(sharpness->of_given->mean_plane_variance_m2);
  return of_whole_map(thicker_m, fmt::format("planes of the map are {} thicker than with the given "
                                             "poses (standard deviation)",
                                             in_words(thicker_m, "m")));
}

std::vector<Found> residual(const GateInput& input, double in_unit(const TrajectoryQuality&),
                            std::string_view unit) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->odometry_edges == 0) {
    return not_judged("the map has no pose graph: its poses were given, or its format is older");
  }
  const double value = in_unit(*trajectory);
  return of_whole_map(
      value, fmt::format("the residuals of the pose graph are {} (RMS)", in_words(value, unit)));
}

std::vector<Found> find_residual(const GateInput& input, const Threshold&) {
  return residual(
      input, [](const TrajectoryQuality& made) { return made.rms_translation_residual_m; }, "m");
}

std::vector<Found> find_turn_residual(const GateInput& input, const Threshold&) {
  return residual(
      input,
      [](const TrajectoryQuality& made) {
        return made.rms_rotation_residual_rad * 180.0 / std::numbers::pi;
      },
      "deg");
}

std::vector<Found> find_pieces(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->pieces.empty()) {
    return not_judged("the map has no pieces of a trajectory");
  }
  const std::size_t count = trajectory->pieces.size();
  std::string text =
      concat("the trajectory has ", count, " pieces, whose relative poses are unknown");
  if (count == 1) text = "the trajectory has one piece";
  for (std::size_t i = 1; i < count; ++i) {
    text +=
        concat((i == 1 ? "; one begins at scan " : ", at scan "), trajectory->pieces[i].first_scan);
  }
  return of_whole_map(static_cast<double>(count), text);
}

std::vector<Found> find_overlap(const GateInput& input, const Threshold&) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory || trajectory->overlap_count == 0) {
    return not_judged("the map has no overlap of scans: its poses were given");
  }
  const double overlap = trajectory->median_overlap;
  return of_whole_map(
      overlap, concat("the median overlap of a scan with earlier scans is ", percent(overlap)));
}

// The sites along a stretch, where those nearest to its ends are of one run.
std::optional<RouteStretch> place_of(const CompiledMap& map, const UnconstrainedStretch& stretch) {
  const std::vector<Site>& sites = map.sites.sites;
  const auto nearest = [&](const Eigen::Vector3d& place_m) {
    const auto found = std::ranges::min_element(sites, {}, [&](const Site& site) {
      return (site.T_map_vehicle.translation() - place_m).squaredNorm();
    });
    return static_cast<std::size_t>(found - sites.begin());
  };
  if (sites.empty()) return std::nullopt;
  const auto [first, last] =
      std::minmax({nearest(stretch.begin_map_m), nearest(stretch.end_map_m)});
  if (sites[first].run != sites[last].run) return std::nullopt;
  return stretch_between(map.sites, first, last);
}

std::vector<Found> find_unconstrained(const GateInput& input, const Threshold& threshold) {
  const auto& trajectory = input.map->trajectory;
  if (!trajectory) return not_judged("the map has no trajectory");
  std::vector<Found> found;
  const auto is_worse = [](const Found& a, const Found& b) { return a.value < b.value; };
  for (const UnconstrainedStretch& stretch : trajectory->unconstrained) {
    if (!stretch.is_assumed()) continue;
    found.push_back({std::nullopt, place_of(*input.map, stretch), stretch.way_m, to_text(stretch)});
  }
  if (found.empty()) {
    return of_whole_map(0.0, "scans constrain all poses, or given poses or measured speeds do");
  }
  const Found worst = *std::ranges::max_element(found, is_worse);
  const double allowed = threshold.at({}).value_or(std::numeric_limits<double>::infinity());
  std::erase_if(found, [&](const Found& one) { return one.value <= allowed; });
  return found.empty() ? std::vector<Found>{worst} : found;
}

std::vector<Found> find_notices(const GateInput& input, const Threshold&) {
  const std::vector<Notice>& notices = input.map->notices;
  if (notices.empty()) return of_whole_map(0.0, "no contradiction in the inputs was accepted");
  std::string text;
  for (const Notice& notice : notices) text += (text.empty() ? "" : "; ") + notice.text;
  return of_whole_map(static_cast<double>(notices.size()), text);
}

// Where poses contradict each other, one of two walls is removed as if it had moved.
std::vector<Found> find_removed_share(const GateInput& input, const Threshold& threshold) {
  const auto column = std::ranges::find(input.map->columns, kRemovedShare, &SiteColumn::name);
  if (column == input.map->columns.end()) {
    return not_judged("the map has no share of removed returns: no mapping drive made it");
  }
  std::vector<double> value;
  for (const float share : column->values) {
    value.push_back(std::isfinite(share) ? share : std::numeric_limits<double>::quiet_NaN());
  }
  const StretchSearch search{input.stretch_m, Bound::kAtMost};
  std::vector<Found> found;
  for (const BadStretch& bad :
       bad_or_worst(input.map->sites, value, search, threshold.at(std::nullopt))) {
    if (bad.last < bad.first) continue;
    const RouteStretch place = stretch_between(input.map->sites, bad.first, bad.last);
    found.push_back(
        {std::nullopt, place, bad.worst,
         fmt::format("{}: {} of the returns were removed as moving over the worst {} m of route",
                     in_words(place), percent(bad.worst), format_double(input.stretch_m))});
  }
  return found.empty() ? not_judged("no scan of the map is near a site") : found;
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"expected-coverage", kMap, kError, kAtLeast, 0.80, "share",
     "Mean over the sites of P(error <= limit) at the chosen range", &at_limits<kExpectedCoverage>},
    {"measured-coverage", kMap, kWarning, kAtLeast, 0.80, "share",
     "Share of the measured sites whose error at the chosen range is within the limit, on the "
     "localization drive",
     find_measured_coverage},
    {"worst-stretch", kMap, kError, kAtLeast, 0.50, "share",
     "Expected coverage of the worst piece of route, `stretch_m` long", find_worst_stretch},
    {"promise-earned", kMap, kWarning, kAtLeast, 1.0, "promises",
     "The map has a promise about the next drive (1) or none (0): its threshold was set on enough "
     "route, by drives that the model was not trained on",
     find_promise},
    {"unmet-share", kMap, kError, kAtMost, 0.50, "share",
     "Share of sites where no range is good enough", &at_limits<kUnmetShare>},
    {"unmet-stretch", kMap, kWarning, kAtMost, 100.0, "m",
     "Longest piece of route without any site where some range is good enough", find_unmet_stretch},
    {"mean-range", kMap, kError, kAtMost, std::nullopt, "m", "Mean chosen range",
     &at_limits<kMeanRange>},
    {"p95-range", kMap, kError, kAtMost, std::nullopt, "m",
     "The range that 95 % of the sites do not exceed", &at_limits<kP95Range>},
    {"expected-work", kMap, kWarning, kAtMost, 0.95, "of the longest",
     "Predicted work of matching: sum over the sites of the factor virtual_points at the chosen "
     "range, over that at the longest",
     find_expected_work},
    {"extrapolated-share", kMap, kError, kAtMost, 0.25, "share",
     "Model support: share of sites unlike those that the model was trained on",
     &at_limits<kExtrapolatedShare>},
    {"model-r-squared", kMap, kWarning, kAtLeast, 0.0, "",
     "Cross-validated R^2 of the model, mean over ranges", find_model_r_squared},
    {"measured-sites", kMap, kWarning, kAtLeast, 0.50, "share",
     "Share of sites where a scan of the localization drive was matched", find_measured_sites},
    {"trajectory-residual", kMap, kError, kAtMost, 0.10, "m",
     "Root mean square of the residuals of the pose graph, translation", find_residual},
    {"trajectory-turn-residual", kMap, kError, kAtMost, 0.5, "deg",
     "Root mean square of the residuals of the pose graph, rotation", find_turn_residual},
    {"trajectory-pieces", kMap, kError, kAtMost, 1.0, "pieces",
     "Pieces of the trajectory, whose relative poses are unknown; the message names the scans that "
     "begin them",
     find_pieces},
    {"trajectory-unconstrained", kMap, kWarning, kAtMost, 20.0, "m",
     "Longest way whose poses rest on an assumed speed, since scans do not constrain them; the "
     "message names the scans, the direction and the uncertainty",
     find_unconstrained},
    {"input-contradictions", kMap, kWarning, kAtMost, 0.0, "contradictions",
     "Contradictions in the inputs that were accepted with a warning, such as given poses that the "
     "scans contradict",
     find_notices},
    {"scan-overlap", kMap, kWarning, kAtLeast, 0.5, "share",
     "Median share of a scan's upright returns that match surfaces seen before it", find_overlap},
    {"plane-thickness", kMap, kWarning, kAtMost, 0.15, "m",
     "Sharpness: root of the mean plane variance of the aligned scans", find_plane_thickness},
    {"thicker-than-given", kMap, kWarning, kAtMost, 0.01, "m",
     "Sharpness: root of the mean plane variance with the poses used, minus that with the given "
     "poses",
     find_thicker_than_given},
    {"less-sharp-than-given", kMap, kWarning, kAtMost, 0.05, "nat",
     "Sharpness: mean map entropy with the poses used, minus that with the given poses",
     find_less_sharp_than_given},
    {"removed-share", kMap, kWarning, kAtMost, 0.10, "share",
     "Share of the returns that were removed as moving, over the worst piece of route, `stretch_m` "
     "long",
     find_removed_share},
};

}  // namespace

std::span<const GateRule> rules_of_map() { return kRules; }

}  // namespace sightline
