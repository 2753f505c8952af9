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
  if (!map.looks) return {};
  SIGHTLINE_TRY(validate(map.looks->predicted));
  SIGHTLINE_TRY(validate(map.looks->ranges));
  return by_family::validate_looks(map.ranges.looks, map.looks->ranges.looks);
}

// Predictions and choice of one table, the ranges' or that of looks that take a sample.
Result<void> validate_choice(const PredictedError& predicted, const RangeTable& ranges,
                             std::size_t sites, const std::vector<LimitQuality>& quality) {
  if (predicted.site_count != sites || ranges.site_count != sites) {
    return invalid_artifact(
        concat("found ", sites, " sites, ", predicted.site_count, " predicted and ",
               ranges.site_count, " with ranges, expected equal numbers"),
        "compiled map");
  }
  if (predicted.looks != ranges.looks) {
    return invalid_artifact("the ranges with predicted errors differ from those to choose from",
                            "compiled map");
  }
  const auto limit_of = [](const LimitPromise& promise) { return promise.limit_m; };
  if (!std::ranges::equal(predicted.limits_m, ranges.promises, {}, {}, limit_of)) {
    return invalid_artifact("the limits of the predictions differ from those of the chosen ranges",
                            "compiled map");
  }
  if (quality.size() != ranges.promises.size()) {
    return invalid_artifact(concat("found ", quality.size(), " limits with a quality"),
                            "compiled map");
  }
  return {};
}

Result<void> validate_agreement(const CompiledMap& map) {
  const std::size_t sites = map.sites.sites.size();
  if (!(map.ndt.frame == map.sites.frame)) {
    return invalid_artifact("NDs and sites are in different frames", "compiled map");
  }
  if (sites == 0) return invalid_artifact("found no site", "compiled map");
  SIGHTLINE_TRY(validate_choice(map.predicted, map.ranges, sites, map.quality));
  if (!map.looks) return {};
  const PredictedError& samples = map.looks->predicted;
  SIGHTLINE_TRY(validate_choice(samples, map.looks->ranges, sites, map.looks->quality));
  if (samples.limits_m != map.predicted.limits_m ||
      samples.out_of_fold != map.predicted.out_of_fold ||
      samples.has_history != map.predicted.has_history) {
    return invalid_artifact(
        "looks and ranges are of different limits, or of different kinds of sites", "compiled map");
  }
  return {};
}

Result<void> validate_factors(const CompiledMap& map) {
  const ByFamily<const FactorTable*> factors = factors_in(map);
  if (!map.factors.factors.empty()) SIGHTLINE_TRY(validate(map.factors));
  if (factors.samples) SIGHTLINE_TRY(validate(**factors.samples));
  return validate_factors(factors, map);
}

Result<void> validate_bounds(const CompiledMap& map) {
  if (!is_world_name(map.world)) {
    return invalid_artifact("the name of its world is empty or not printable", "compiled map");
  }
  if (map.ranges.looks.size() > kMostRanges || map.ranges.promises.size() > kMostLimits) {
    return invalid_artifact("more ranges or limits than a map can contain", "compiled map");
  }
  if (!(map.reach_m > 0.0) || !(map.reach_m <= map.ndt.tile_m)) {
    return invalid_artifact(concat("found a reach of ", format_double(map.reach_m),
                                   " m, expected above 0 and at most a tile"),
                            "compiled map");
  }
  // Beyond this a site has no cell of 32 bits in the section "look-up", whose cells have 16 m at
  // least.
  constexpr double kFarthestSite_m = 0x1.0p34;
  for (const Site& site : map.sites.sites) {
    if (site.p_map_m.head<2>().cwiseAbs().maxCoeff() < kFarthestSite_m) continue;
    return invalid_artifact("a site is more than 17 million km from the frame's origin",
                            "compiled map");
  }
  // Beyond this the offset of a mean from the centre of its cell overflows.
  constexpr double kLargestCell_m = 200.0;
  if (map.ndt.cell_m > kLargestCell_m) {
    return invalid_artifact("the cells are larger than 200 m", "compiled map");
  }
  if (map.tile_drives) SIGHTLINE_TRY(validate(*map.tile_drives));
  if (map.recordings) SIGHTLINE_TRY(validate(*map.recordings));
  for (std::size_t i = 1; i < map.definitions.size(); ++i) {
    if (map.definitions[i - 1].name >= map.definitions[i].name) {
      return invalid_artifact("the names of definitions do not ascend", "compiled map");
    }
  }
  if (!map.model.bytes.empty() && sha256(map.model.bytes) != map.model.digest) {
    return invalid_artifact("the model does not match its digest", "compiled map");
  }
  return {};
}

}  // namespace

Result<void> validate_factors(const ByFamily<const FactorTable*>& factors, const CompiledMap& map) {
  if (factors.ranges->factors.empty()) {
    return factors.samples ? invalid_artifact("the map has factors of looks, but none of ranges",
                                              "compiled map")
                           : Result<void>();
  }
  const auto is_of = [&](const FactorTable& table, const RangeTable& choice) {
    return table.site_count == choice.site_count && table.looks == choice.looks &&
           table.factors.size() <= kMostFactors;
  };
  if (!is_of(*factors.ranges, map.ranges)) {
    return invalid_artifact("the factors are of other sites or ranges, or too many",
                            "compiled map");
  }
  if (factors.samples && (!map.looks || !is_of(**factors.samples, map.looks->ranges))) {
    return invalid_artifact("the factors of looks are of other sites or looks, or too many",
                            "compiled map");
  }
  return {};
}

Result<void> validate(const CompiledMap& map) {
  for (const Result<void>& valid :
       {validate_artifacts(map), validate_agreement(map), validate_factors(map),
        validate_bounds(map), validate_columns(map.columns, map.sites.sites.size())}) {
    if (!valid) return valid.error();
  }
  return {};
}

}  // namespace sightline
