#include "passes/factors/compute_factors.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/parallel.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/factors/paper_factors.h"
#include "passes/factors/virtual_scan.h"
#include "passes/matching/scan_preparation.h"

// A group of consecutive sites computes once what depends on an ND alone: class, bin of the normal
// and grid of self scores. Each site sums over shells and localizes its virtual scan.

namespace sightline {
namespace {

// The NDs that a group of neighbouring sites looks at, and what each is for all of them. Lists run
// in parallel.
struct GroupNds {
  std::vector<Nd> nds;
  std::vector<std::uint32_t> all;  // 0, 1, 2, ...
  std::vector<int> dimension_class;
  std::vector<int> normal_bin;  // -1 where the ND is not planar
  std::vector<ShiftGrid> self_score;
};

// Enough for neighbours to share most of their NDs; few enough for the grids to stay in memory.
constexpr std::size_t kSitesPerGroup = 64;

// So that what lies at exactly the reach is decided by its distance, not by rounding here.
constexpr double kSlack_m = 0.01;

bool is_within(double reach_m, const Eigen::Vector3d& mean_m, std::span<const Site> sites) {
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    return (mean_m - site.p_map_m).squaredNorm() <= reach_m * reach_m;
  });
}

std::vector<Nd> nds_within(double reach_m, const NdtMap& map, const TileIndex& index,
                           std::span<const Site> sites) {
  Eigen::Vector3d low_m = sites[0].p_map_m;
  Eigen::Vector3d high_m = sites[0].p_map_m;
  for (const Site& site : sites) {
    low_m = low_m.cwiseMin(site.p_map_m);
    high_m = high_m.cwiseMax(site.p_map_m);
  }
  const TileKey low = tile_key(low_m.array() - reach_m, map.tile_m);
  const TileKey high = tile_key(high_m.array() + reach_m, map.tile_m);
  std::vector<Nd> found;
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      const auto tile = index.find({x, y});
      if (tile == index.end()) continue;
      for (std::uint32_t i = tile->second.first; i < tile->second.second; ++i) {
        if (is_within(reach_m, map.nds[i].mean_m, sites)) found.push_back(map.nds[i]);
      }
    }
  }
  return found;
}

GroupNds gather_nds(const FactorWorld& world, std::span<const Site> sites, int threads) {
  GroupNds found;
  found.nds = nds_within(world.ranges_m.back() + kSlack_m, world.map, world.index, sites);
  for (const Nd& nd : found.nds) {
    found.all.push_back(static_cast<std::uint32_t>(found.all.size()));
    found.dimension_class.push_back(dimension_class(nd));
    const bool is_planar = found.dimension_class.back() == 2;
    found.normal_bin.push_back(is_planar ? normal_bin(nd.eigenvectors.col(2)) : -1);
  }
  found.self_score = parallel_map<ShiftGrid>(found.nds.size(), threads, [&](std::size_t i) {
    return self_score(found.nds[i], world.grid);
  });
  return found;
}

constexpr std::size_t kFactorCount = 20;
constexpr std::array<std::string_view, kFactorCount> kFactorNames = {
    "feature_count", "d1_count", "d2_count",        "d3_count",       "d1_ratio",
    "d2_ratio",      "d3_ratio", "occupancy_ratio", "normal_entropy", "r_average",
    "score_entropy", "crlb_max", "crlb_min",        "crlb_heading",   "crlb_yaw",
    "hz_lmin",       "flat_050", "virtual_points",  "virtual_error",  "rival_score"};

// What one site sees.
struct View {
  const Site& site;
  std::span<const float> depth_m;
  std::span<const Eigen::Vector3d> virtual_points_m;
};

// Fills [range][factor] of one site; returns how many virtual points lie in no valid ND.
std::size_t compute_site(const FactorWorld& world, const GroupNds& group, const View& view,
                         std::span<double> values) {
  const Vicinity vicinity = vicinity_of(view.site.p_map_m, group.nds, group.all, world.ranges_m);
  const std::vector<double> counts = feature_count(vicinity);
  const std::vector<ByDimension> dimensions = dimension_counts(vicinity, group.dimension_class);
  const std::vector<double> occupancy = occupancy_ratio(view.depth_m, world.ranges_m);
  const std::vector<double> normals = normal_entropy(vicinity, group.normal_bin);
  const std::vector<double> distances_m = r_average(vicinity);
  const std::vector<ShiftGrid> scores = self_scores(vicinity, group.self_score);
  const std::vector<ScanInformation> informations = scan_information(
      view.site.p_map_m, view.virtual_points_m, world.map, world.grid, world.ranges_m);
  for (std::size_t range = 0; range < world.ranges_m.size(); ++range) {
    const auto& [d1, d2, d3] = dimensions[range];
    const auto [d1_ratio, d2_ratio, d3_ratio] = dimension_ratios(dimensions[range]);
    const Crlb bound = crlb(informations[range].pose);
    const std::vector<Eigen::Vector3d> points_m =
        crop(view.virtual_points_m, world.ranges_m[range]);
    const VirtualMatch match = virtual_match(
        world.localizer,
        {view.site.p_map_m, view.site.T_map_vehicle.linear(), points_m, bound.heading_deg});
    // In the order of kFactorNames.
    const std::array<double, kFactorCount> row = {
        counts[range],
        d1,
        d2,
        d3,
        d1_ratio,
        d2_ratio,
        d3_ratio,
        occupancy[range],
        normals[range],
        distances_m[range],
        score_entropy(scores[range]),
        bound.max_m,
        bound.min_m,
        bound.heading_deg,
        bound.yaw_rad,
        hz_lmin(informations[range].planar_normals),
        flat_050(scores[range]),
        static_cast<double>(informations[range].point_count),
        match.error_m,
        match.rival_score};
    std::copy(row.begin(), row.end(), values.subspan(range * kFactorCount).begin());
  }
  return informations.back().unmatched_count;
}

Error mismatched(std::string message) {
  return {ErrorCode::kMismatchedInputs, std::move(message), "", "pass compute-factors"};
}

Result<void> check_inputs(const NdtMap& map, const Sites& sites, const DepthImages& depth,
                          const VirtualScans& scans, double longest_m) {
  if (map.frame != sites.frame) return mismatched("map and sites are in different frames");
  const std::size_t expected = sites.sites.size();
  if (depth.site_count != expected || scans.site_count() != expected) {
    return mismatched(concat("found depth images of ", depth.site_count,
                             " sites and virtual scans of ", scans.site_count(), ", expected ",
                             expected));
  }
  const double reach_m = std::min(depth.longest_range_m, scans.longest_range_m);
  if (reach_m < longest_m) {
    return mismatched(concat("depth images or virtual scans end at ", std::to_string(reach_m),
                             " m, before the longest range of ", std::to_string(longest_m), " m"));
  }
  return {};
}

TileIndex tile_index(const NdtMap& map) {
  TileIndex index;
  for (std::uint32_t i = 0; i < map.nds.size(); ++i) {
    const TileKey tile = tile_of(map.nds[i].key, map.cell_m, map.tile_m);
    index.try_emplace(tile, i, i).first->second.second = i + 1;
  }
  return index;
}

}  // namespace

Result<FactorWorld> make_factor_world(const NdtMap& map, const std::vector<double>& ranges_m) {
  const bool ascends =
      std::ranges::adjacent_find(ranges_m, std::greater_equal<>()) == ranges_m.end();
  if (ranges_m.empty() || !(ranges_m.front() > 0.0) || !ascends) {
    return Error{ErrorCode::kBadValue, "ranges_m must be above 0 m and ascending", "",
                 "pass compute-factors"};
  }
  return FactorWorld{map, make_match_grid(map),
                     make_localizer(map, localizer_options(LocalizerKind::kSearching)),
                     tile_index(map), ranges_m};
}

Result<SeenFactors> compute_factors(const PassContext& ctx, const FactorWorld& world,
                                    const Sites& sites, const DepthImages& depth,
                                    const VirtualScans& scans) {
  const double longest_m = world.ranges_m.back();
  SIGHTLINE_TRY(check_inputs(world.map, sites, depth, scans, longest_m));
  SeenFactors seen;
  FactorTable& table = seen.table;
  table.looks = every_return_at(world.ranges_m);
  table.factors.assign(kFactorNames.begin(), kFactorNames.end());
  table.site_count = depth.site_count;
  const std::size_t site_count = sites.sites.size();
  const SiteShape shape = table.shape();
  table.values.resize(shape.size(site_count));
  std::vector<std::size_t> unmatched(site_count);
  // One group's grids at a time are in memory.
  for (std::size_t begin = 0; begin < site_count; begin += kSitesPerGroup) {
    const std::size_t size = std::min(kSitesPerGroup, site_count - begin);
    const std::span<const Site> members = std::span(sites.sites).subspan(begin, size);
    const GroupNds group = gather_nds(world, members, ctx.threads);
    parallel_for(size, ctx.threads, [&](std::size_t i) {
      const std::size_t site = begin + i;
      const View view{members[i], depth.image_of(site), scans.points_of(site)};
      unmatched[site] = compute_site(
          world, group, view, std::span(table.values).subspan(shape.size(site), shape.size(1)));
    });
  }
  seen.point_count = scans.points_m.size();
  for (const std::size_t count : unmatched) seen.unmatched_count += count;
  return seen;
}

}  // namespace sightline
