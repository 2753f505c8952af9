#include <algorithm>

#include "formats/map/compiled_map.h"
#include "formats/map/factor_layer.h"
#include "formats/map/site_columns.h"
#include "formats/reader/map_layout.h"

// Whether the parts of a map agree.

namespace sightline {
namespace {

Result<void> validate_artifacts(const CompiledMap& map) {
  for (const Result<void>& valid :
       {validate(map.ndt), validate(map.sites), validate(map.predicted), validate(map.ranges),
        validate(map.sensor), validate(map.measurement.localizer), validate(map.model.localizer)}) {
    if (!valid) return valid.error();
  }
  return {};
}

// Predictions and choice of one table, the ranges' or that of looks that take a sample.
Result<void> validate_choice(const PredictedError& predicted, const RangeTable& ranges,
                             std::size_t sites, const std::vector<LimitQuality>& quality) {
  if (predicted.site_count != sites || ranges.site_count != sites) {
    return invalid_artifact("found " + std::to_string(sites) + " sites, " +
                                std::to_string(predicted.site_count) + " predicted and " +
                                std::to_string(ranges.site_count) +
                                " with ranges, expected equal numbers",
                            "compiled map");
  }
  if (predicted.looks != ranges.looks) {
    return invalid_artifact("errors are predicted at other ranges than are chosen from",
                            "compiled map");
  }
  const auto limit_of = [](const LimitPromise& promise) { return promise.limit_m; };
  if (!std::ranges::equal(predicted.limits_m, ranges.promises, {}, {}, limit_of)) {
    return invalid_artifact("errors are predicted for other limits than ranges are chosen for",
                            "compiled map");
  }
  if (quality.size() != ranges.promises.size()) {
    return invalid_artifact("found " + std::to_string(quality.size()) + " limits with a quality",
                            "compiled map");
  }
  return {};
}

Result<void> validate_agreement(const CompiledMap& map) {
  const std::size_t sites = map.sites.sites.size();
  if (!(map.ndt.frame == map.sites.frame)) {
    return invalid_artifact("NDs and sites lie in different frames", "compiled map");
  }
  if (sites == 0) return invalid_artifact("found no site", "compiled map");
  SIGHTLINE_TRY(validate_choice(map.predicted, map.ranges, sites, map.quality));
  if (map.predicted.of_samples.size() != map.ranges.of_samples.size()) {
    return invalid_artifact(
        "looks are predicted and not chosen from, or chosen from and not predicted",
        "compiled map");
  }
  if (map.ranges.of_samples.empty()) return {};
  const PredictedError& samples = map.predicted.of_samples.front();
  SIGHTLINE_TRY(validate_choice(samples, map.ranges.of_samples.front(), sites, map.look_quality));
  if (samples.limits_m != map.predicted.limits_m ||
      samples.out_of_fold != map.predicted.out_of_fold ||
      samples.has_history != map.predicted.has_history) {
    return invalid_artifact(
        "looks and ranges are of different limits, or of different kinds of sites", "compiled map");
  }
  return {};
}

Result<void> validate_bounds(const CompiledMap& map) {
  if (!is_world_name(map.world)) {
    return invalid_artifact("the name of its world is empty or not printable", "compiled map");
  }
  if (map.ranges.looks.size() > kMostRanges || map.ranges.promises.size() > kMostLimits) {
    return invalid_artifact("more ranges or limits than a map can hold", "compiled map");
  }
  if (!(map.reach_m > 0.0) || !(map.reach_m <= map.ndt.tile_m)) {
    return invalid_artifact("found a reach of " + format_double(map.reach_m) +
                                " m, expected above 0 and at most a tile",
                            "compiled map");
  }
  // Beyond this a site has no cell of 32 bits in the section "look-up", whose cells have 16 m at
  // least.
  constexpr double kFarthestSite_m = 0x1.0p34;
  for (const Site& site : map.sites.sites) {
    if (site.p_map_m.head<2>().cwiseAbs().maxCoeff() < kFarthestSite_m) continue;
    return invalid_artifact("a site lies more than 17 million km from the frame's origin",
                            "compiled map");
  }
  // Beyond this the offset of a mean from the centre of its cell overflows.
  constexpr double kLargestCell_m = 200.0;
  if (map.ndt.cell_m > kLargestCell_m) {
    return invalid_artifact("cells of more than 200 m", "compiled map");
  }
  if (map.tile_drives) SIGHTLINE_TRY(validate(*map.tile_drives));
  for (std::size_t i = 1; i < map.definitions.size(); ++i) {
    if (map.definitions[i - 1].name >= map.definitions[i].name) {
      return invalid_artifact("the names of definitions do not ascend", "compiled map");
    }
  }
  if (!map.model.bytes.empty() && sha256(map.model.bytes) != map.model.digest) {
    return invalid_artifact("the model is not the one that its digest names", "compiled map");
  }
  return {};
}

}  // namespace

Result<void> validate_factors(const FactorTable& factors, const Sites& sites,
                              const RangeTable& ranges) {
  if (factors.factors.empty()) {
    return factors.of_samples.empty()
               ? Result<void>()
               : invalid_artifact("there are factors of looks alone", "compiled map");
  }
  SIGHTLINE_TRY(validate(factors));
  if (factors.site_count != sites.sites.size() || factors.looks != ranges.looks ||
      factors.factors.size() > kMostFactors) {
    return invalid_artifact("the factors are of other sites or ranges, or too many",
                            "compiled map");
  }
  for (const FactorTable& samples : factors.of_samples) {
    if (ranges.of_samples.empty() || samples.site_count != sites.sites.size() ||
        samples.looks != ranges.of_samples.front().looks || samples.factors.size() > kMostFactors) {
      return invalid_artifact("the factors of looks are of other sites or looks, or too many",
                              "compiled map");
    }
  }
  return {};
}

Result<void> validate(const CompiledMap& map) {
  for (const Result<void>& valid :
       {validate_artifacts(map), validate_agreement(map),
        validate_factors(map.factors, map.sites, map.ranges), validate_bounds(map),
        validate_columns(map.columns, map.sites.sites.size())}) {
    if (!valid) return valid.error();
  }
  return {};
}

}  // namespace sightline
