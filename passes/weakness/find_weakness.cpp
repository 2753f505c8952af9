#include "passes/weakness/find_weakness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string_view>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"
#include "passes/factors/virtual_scan.h"
#include "passes/rays/cast_scans.h"

namespace sightline {
namespace {

// NDs this much beyond the range still catch samples: a cell and the extent of a patch.
constexpr double kBeyondRange_m = 4.0;

// Sites of the stretch that advice is judged at: the worst, then others evenly along it.
std::vector<std::size_t> judged_sites(const WeakStretch& stretch, std::size_t most) {
  std::vector<std::size_t> judged = {stretch.worst_site};
  const std::size_t count = stretch.last_site - stretch.first_site + 1;
  const std::size_t others = std::min(most, count);
  for (std::size_t i = 0; i < others; ++i) {
    const std::size_t site = stretch.first_site + (2 * i + 1) * count / (2 * others);
    if (std::ranges::find(judged, site) == judged.end()) judged.push_back(site);
  }
  if (judged.size() > most) judged.resize(most);
  return judged;
}

// One scan of the map for each metre of route from which the target is near.
std::vector<double> scans_of_views(const WeakStretch& stretch, const AdviceOptions& options,
                                   double spacing_m, std::size_t count) {
  const double route_m = stretch.to_m - stretch.from_m + 2.0 * options.beyond_m;
  return std::vector<double>(count, route_m / spacing_m / static_cast<double>(count));
}

// The value of a factor at a site, by that look; nothing where the map does not hold it.
std::optional<double> factor_at(const FactorTable& factors, std::size_t site, const Look& look,
                                std::string_view name) {
  const auto column = std::ranges::find(factors.factors, name);
  const auto row = std::ranges::find(factors.looks, look);
  if (column != factors.factors.end() && row != factors.looks.end()) {
    return factors.at(site, static_cast<std::size_t>(row - factors.looks.begin()),
                      static_cast<std::size_t>(column - factors.factors.begin()));
  }
  return std::nullopt;
}

// What the map's own factors tell of a site, by that look; nothing where it holds none.
std::optional<Crlb> stored_bound(const CompiledMap& map, std::size_t site, const Look& look) {
  const auto stored = [&](std::string_view name) {
    const std::optional<double> of_range = factor_at(map.factors, site, look, name);
    return of_range || !map.looks ? of_range : factor_at(map.looks->factors, site, look, name);
  };
  const std::optional<double> max_m = stored("crlb_max");
  const std::optional<double> min_m = stored("crlb_min");
  const std::optional<double> heading_deg = stored("crlb_heading");
  const std::optional<double> yaw_rad = stored("crlb_yaw");
  if (!max_m || !min_m || !heading_deg || !yaw_rad) return std::nullopt;
  return Crlb{*max_m, *min_m, *heading_deg, *yaw_rad};
}

LooseDirection loose_direction(const CompiledMap& map, const WeakStretch& stretch,
                               const SiteView& view) {
  const std::optional<Crlb> stored = stored_bound(map, stretch.worst_site, stretch.worst.look);
  const Crlb bound = stored.value_or(crlb(view.information));
  LooseDirection loose;
  loose.is_of_map = stored.has_value();
  loose.heading_deg = bound.heading_deg;
  loose.off_road_deg = off_road_deg(map.sites.sites[stretch.worst_site], bound.heading_deg);
  loose.std_m = bound.max_m;
  loose.strong_std_m = bound.min_m;
  loose.yaw_rad = bound.yaw_rad;
  return loose;
}

// Along the loose direction of the stretch, at each judged site.
std::vector<double> loose_std_m(const CompiledMap& map, const ExplainedStretch& explained,
                                const std::vector<SiteView>& views) {
  std::vector<double> std_m;
  for (const SiteView& view : views) {
    const Crlb bound =
        stored_bound(map, view.site, explained.stretch.worst.look).value_or(crlb(view.information));
    std_m.push_back(std_along_m(bound, explained.loose.heading_deg));
  }
  return std_m;
}

Result<ExplainedStretch> explain(PassContext& ctx, const WeaknessOptions& options,
                                 const CompiledMap& map, const WeakStretch& stretch) {
  const std::vector<std::size_t> judged = judged_sites(stretch, options.judged_sites);
  std::vector<Eigen::Vector3d> places_m;
  for (const std::size_t site : judged) places_m.push_back(map.sites.sites[site].p_map_m);
  ViewOptions view_options;
  view_options.range_m = stretch.worst.look.range_m;
  if (map.measurement.leaf_m > 0.0) view_options.leaf_m = map.measurement.leaf_m;
  view_options.view = AzimuthView(map.sensor);
  const NearNds nds = nds_near(map.ndt, places_m, view_options.range_m + kBeyondRange_m);
  const std::vector<Eigen::Vector3d> directions = beam_directions(map.sensor);
  SIGHTLINE_ASSIGN(const std::vector<SiteView> views,
                   views_from(ctx, view_options, nds, map.sites, judged, directions));
  ExplainedStretch explained;
  explained.stretch = stretch;
  explained.kind = kind_at(map.columns, stretch.worst_site);
  explained.loose = loose_direction(map, stretch, views.front());
  explained.sights = upright_sights(views.front(), nds, explained.loose.heading_deg);
  explained.rival_score =
      factor_at(map.factors, stretch.worst_site, stretch.worst.look, "rival_score");
  explained.cause = cause_of(explained.sights, explained.rival_score, view_options.range_m);
  const std::vector<double> weights =
      scans_of_views(stretch, options.advice, map.sites.spacing_m, views.size());
  const std::vector<double> std_m = loose_std_m(map, explained, views);
  const StretchScene scene{nds,
                           map.sites,
                           views,
                           std_m,
                           weights,
                           directions,
                           view_options,
                           stretch.first_site,
                           stretch.last_site,
                           explained.loose.heading_deg};
  explained.advice = advise_targets(ctx, options.advice, scene);
  return explained;
}

void sum_up(const CompiledMap& map, const std::vector<BestLook>& best,
            const std::vector<WeakStretch>& stretches, Weakness& found) {
  const double spacing_m = map.sites.spacing_m;
  found.route_m = spacing_m * static_cast<double>(best.size());
  found.stretch_count = stretches.size();
  for (const WeakStretch& stretch : stretches) {
    found.weak_m += spacing_m * static_cast<double>(stretch.last_site - stretch.first_site + 1);
    found.unmet_m += spacing_m * static_cast<double>(stretch.unmet_count);
  }
  const auto thinnest = std::ranges::min_element(best, {}, &BestLook::margin);
  found.thinnest_site = static_cast<std::size_t>(thinnest - best.begin());
  found.thinnest = *thinnest;
}

// Fewer upright surfaces of 2 m than this are two fronts of 10 m, one storey high.
constexpr std::size_t kFew = 20;
// One in twenty surfaces, at right angles to all others, is this one-sided.
constexpr double kOneSided = 0.95;
// A rival this good is within what traffic and other parked cars take from a score.
constexpr double kRival = 0.85;
constexpr double kFarShare = 0.5;  // of the range
constexpr double kHolds = 0.866;   // cosine of 30 degrees
constexpr double kUpright = 0.5;   // sine of 30 degrees: height of the normal

// Numbers of the NDs in which the scan has samples.
std::set<std::uint32_t> nds_in_sight(const SiteView& view, const NearNds& nds) {
  std::set<std::uint32_t> numbers;
  for (const auto& [key, voxel] : view.voxels) {
    const std::uint32_t number = nds.index.find(cell_of(voxel, view.p_map_m, nds.cell_m));
    if (number != CellIndex::kNone) numbers.insert(number);
  }
  return numbers;
}

}  // namespace

Result<Weakness> find_weakness(PassContext& ctx, const WeaknessOptions& options,
                               const CompiledMap& map) {
  if (map.sites.sites.empty()) {
    return Error{ErrorCode::kBadArgument, "the map has no sites"};
  }
  if (options.advice.farthest_m < options.advice.nearest_m) {
    return Error{
        ErrorCode::kBadArgument,
        concat("--farthest is ", format_double(options.advice.farthest_m),
               " m, expected at least --nearest, ", format_double(options.advice.nearest_m), " m")};
  }
  SIGHTLINE_ASSIGN(const std::size_t limit, limit_of(map, options.stretches.limit_m));
  const std::vector<BestLook> best = best_looks(map, limit);
  const std::vector<WeakStretch> stretches = weak_stretches(map.sites, best, options.stretches);
  Weakness found;
  found.limit_m = map.ranges.promises[limit].limit_m;
  found.options = options;
  sum_up(map, best, stretches, found);
  const std::size_t count = std::min(options.most, stretches.size());
  for (std::size_t i = 0; i < count; ++i) {
    SIGHTLINE_ASSIGN(ExplainedStretch explained, explain(ctx, options, map, stretches[i]));
    found.stretches.push_back(std::move(explained));
    ctx.progress(i + 1, count);
  }
  return found;
}

std::string_view name_of(WeakCause cause) {
  constexpr std::array<std::string_view, 5> kNames = {"empty", "one-sided", "repeated", "distant",
                                                      "unclear"};
  return kNames[static_cast<std::size_t>(cause)];
}

UprightSights upright_sights(const SiteView& view, const NearNds& nds, double loose_heading_deg) {
  const SinCos loose = portable_sin_cos(loose_heading_deg * std::numbers::pi / 180.0);
  const Eigen::Vector2d way(loose.cos, loose.sin);
  UprightSights sights;
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (const std::uint32_t number : nds_in_sight(view, nds)) {
    const Nd& nd = nds.nds[number];
    const Eigen::Vector3d normal = nd.eigenvectors.col(2);
    if (dimension_class(nd) != 2 || std::abs(normal.z()) > kUpright) continue;
    ++sights.count;
    const Eigen::Vector2d level = normal.head<2>().normalized();
    normals += level * level.transpose();
    if (std::abs(level.dot(way)) < kHolds) continue;
    ++sights.holding_count;
    const double away_m = (nd.mean_m - view.p_map_m).norm();
    sights.nearest_holding_m = std::min(away_m, sights.nearest_holding_m.value_or(away_m));
  }
  if (sights.count == 0) return sights;
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(normals);
  sights.one_sidedness = 1.0 - eigen.values[0] / eigen.values[1];
  return sights;
}

WeakCause cause_of(const UprightSights& sights, std::optional<double> rival_score, double range_m) {
  if (sights.count < kFew) return WeakCause::kEmpty;
  if (sights.one_sidedness > kOneSided) return WeakCause::kOneSided;
  if (rival_score && *rival_score > kRival) return WeakCause::kRepeated;
  if (!sights.nearest_holding_m || *sights.nearest_holding_m > kFarShare * range_m) {
    return WeakCause::kDistant;
  }
  return WeakCause::kUnclear;
}

}  // namespace sightline
