#include "passes/compute_factors.h"

#include <algorithm>
#include <atomic>
#include <map>

#include "compiler/base/check.h"
#include "compiler/base/parallel.h"
#include "passes/factors/dimensions.h"
#include "passes/factors/feature_count.h"
#include "passes/factors/normal_entropy.h"
#include "passes/factors/occupancy_ratio.h"
#include "passes/factors/r_average.h"
#include "passes/factors/score_entropy.h"

// Sites are taken in groups of consecutive ones. A group gathers the NDs within reach of any of its
// sites and works out once what belongs to the ND alone: class, bin of the normal, and the grid of
// self scores, which is by far the most work. Each site then sorts its NDs by distance and sums
// over shells.

namespace sightline {
namespace {

// Enough for neighbours to share most of their NDs; few enough to share work between threads.
constexpr std::size_t kSitesPerGroup = 64;
// A group gathers a little too much, so that rounding at the longest range is decided in one place.
constexpr double kGatherSlack_m = 0.01;

const std::vector<std::string> kFactorNames = {
    "feature_count", "d1_count",        "d2_count",       "d3_count",  "d1_ratio",     "d2_ratio",
    "d3_ratio",      "occupancy_ratio", "normal_entropy", "r_average", "score_entropy"};

// NDs by the tile that holds them; `map.nds` lies in order of tiles.
struct TileIndex {
  std::map<TileKey, std::pair<std::uint32_t, std::uint32_t>> range_of_tile;

  explicit TileIndex(const NdtMap& map) {
    for (std::uint32_t i = 0; i < map.nds.size(); ++i) {
      const TileKey tile = tile_of(map.nds[i].key, map.cell_m, map.tile_m);
      range_of_tile.try_emplace(tile, i, i).first->second.second = i + 1;
    }
  }
};

// The NDs that a group of sites looks at, and what each is whoever looks.
struct GroupNds {
  std::vector<Nd> nds;
  std::vector<std::uint32_t> all;  // 0, 1, 2, ...
  std::vector<int> dimension_class;
  std::vector<int> normal_bin;  // -1 where the ND is not planar
  std::vector<ShiftGrid> self_score;
};

bool is_within_reach(const Eigen::Vector3d& mean_m, std::span<const Site> sites, double reach_m) {
  return std::any_of(sites.begin(), sites.end(), [&](const Site& site) {
    return (mean_m - site.p_map_m).squaredNorm() <= reach_m * reach_m;
  });
}

std::vector<Nd> nds_within_reach(const NdtMap& map, const TileIndex& index,
                                 std::span<const Site> sites, double reach_m) {
  Eigen::Vector3d low_m = sites[0].p_map_m;
  Eigen::Vector3d high_m = sites[0].p_map_m;
  for (const Site& site : sites) {
    low_m = low_m.cwiseMin(site.p_map_m);
    high_m = high_m.cwiseMax(site.p_map_m);
  }
  std::vector<Nd> found;
  const CellKey low = cell_key(low_m.array() - reach_m, map.tile_m);
  const CellKey high = cell_key(high_m.array() + reach_m, map.tile_m);
  for (std::int32_t x = low.x; x <= high.x; ++x) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      const auto tile = index.range_of_tile.find({x, y});
      if (tile == index.range_of_tile.end()) continue;
      for (std::uint32_t i = tile->second.first; i < tile->second.second; ++i) {
        if (is_within_reach(map.nds[i].mean_m, sites, reach_m)) found.push_back(map.nds[i]);
      }
    }
  }
  return found;
}

GroupNds gather(const NdtMap& map, const TileIndex& index, const MatchGrid& grid,
                std::span<const Site> sites, double reach_m) {
  GroupNds group;
  group.nds = nds_within_reach(map, index, sites, reach_m);
  for (const Nd& nd : group.nds) {
    group.all.push_back(static_cast<std::uint32_t>(group.all.size()));
    group.dimension_class.push_back(dimension_class(nd));
    const bool is_planar = group.dimension_class.back() == 2;
    group.normal_bin.push_back(is_planar ? normal_bin(nd.eigenvectors.col(2)) : -1);
    group.self_score.push_back(self_score(nd, grid));
  }
  return group;
}

// Fills [range][factor] of one site.
void compute_site(const GroupNds& group, const Site& site, std::span<const float> depth_m,
                  const std::vector<double>& ranges_m, std::span<double> values) {
  const Vicinity vicinity = vicinity_of(site.p_map_m, group.nds, group.all, ranges_m);
  const std::vector<double> counts = feature_count(vicinity);
  const std::vector<ByDimension> dimensions = dimension_counts(vicinity, group.dimension_class);
  const std::vector<double> occupancy = occupancy_ratio(depth_m, ranges_m);
  const std::vector<double> normals = normal_entropy(vicinity, group.normal_bin);
  const std::vector<double> distances = r_average(vicinity);
  const std::vector<ShiftGrid> scores = self_scores(vicinity, group.self_score);
  for (std::size_t range = 0; range < ranges_m.size(); ++range) {
    const ByDimension ratios = dimension_ratios(dimensions[range]);
    const std::vector<double> row = {counts[range],
                                     dimensions[range][0],
                                     dimensions[range][1],
                                     dimensions[range][2],
                                     ratios[0],
                                     ratios[1],
                                     ratios[2],
                                     occupancy[range],
                                     normals[range],
                                     distances[range],
                                     score_entropy(scores[range])};
    SIGHTLINE_CHECK(row.size() == kFactorNames.size());
    std::copy(row.begin(), row.end(), values.begin() + static_cast<long>(range * row.size()));
  }
}

Error mismatched(std::string message) {
  return {ErrorCode::kMismatchedInputs, std::move(message), "", "pass compute-factors"};
}

Result<void> check_inputs(const ComputeFactorsOptions& options, const NdtMap& map,
                          const Sites& sites, const DepthImages& depth) {
  const std::vector<double>& ranges_m = options.ranges_m;
  const bool ascends = std::adjacent_find(ranges_m.begin(), ranges_m.end(),
                                          std::greater_equal<>()) == ranges_m.end();
  if (ranges_m.empty() || !(ranges_m.front() > 0.0) || !ascends) {
    return Error{ErrorCode::kBadValue, "ranges_m must ascend from above 0", "",
                 "pass compute-factors"};
  }
  if (map.frame != sites.frame) return mismatched("map and sites lie in different frames");
  if (depth.site_count != sites.sites.size()) {
    return mismatched("found depth images of " + std::to_string(depth.site_count) +
                      " sites, expected " + std::to_string(sites.sites.size()));
  }
  if (depth.longest_range_m < ranges_m.back()) {
    return mismatched("depth images end at " + std::to_string(depth.longest_range_m) +
                      " m, before the longest range of " + std::to_string(ranges_m.back()) + " m");
  }
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(ComputeFactorsOptions& options) {
  return {numbers("ranges_m", options.ranges_m, "observation ranges, m", 1.0, 1000.0)};
}

Result<FactorTable> compute_factors(PassContext& ctx, const ComputeFactorsOptions& options,
                                    const NdtMap& map, const Sites& sites,
                                    const DepthImages& depth) {
  const Result<void> checked = check_inputs(options, map, sites, depth);
  if (!checked) return checked.error();
  FactorTable table;
  table.ranges_m = options.ranges_m;
  table.factors = kFactorNames;
  table.site_count = static_cast<std::uint32_t>(sites.sites.size());
  const std::size_t row_size = table.ranges_m.size() * table.factors.size();
  table.values.resize(table.site_count * row_size);
  const TileIndex index(map);
  const MatchGrid grid = make_match_grid(map);
  const std::size_t group_count = (sites.sites.size() + kSitesPerGroup - 1) / kSitesPerGroup;
  std::atomic<std::size_t> done = 0;
  parallel_for(group_count, ctx.threads, [&](std::size_t i) {
    const std::size_t begin = i * kSitesPerGroup;
    const std::size_t end = std::min(sites.sites.size(), begin + kSitesPerGroup);
    const std::span<const Site> members = std::span(sites.sites).subspan(begin, end - begin);
    const GroupNds group =
        gather(map, index, grid, members, table.ranges_m.back() + kGatherSlack_m);
    for (std::size_t site = begin; site < end; ++site) {
      const std::span<const float> image =
          std::span(depth.distance_m)
              .subspan(site * depth.cells_per_site(), depth.cells_per_site());
      compute_site(group, sites.sites[site], image, table.ranges_m,
                   std::span(table.values).subspan(site * row_size, row_size));
      ctx.progress(++done, sites.sites.size());
    }
  });
  return table;
}

}  // namespace sightline
