#include "passes/map/choose_nds.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "formats/grid/point_grid.h"
#include "formats/map/container/small_nd.h"
#include "formats/tables/stored_table_writer.h"
#include "passes/matching/grid/match_grid.h"

namespace sightline {
namespace {

struct Candidate {
  std::size_t nd = 0;
  double worth = 0.0;
};

// By how much an ND holds a vehicle along its normal: the inverse of its variance there, for as
// many points as a few scans give. Matching sees no variance below a hundredth of the largest.
double worth_of(const Nd& nd) {
  constexpr double kMostPoints = 100.0;
  constexpr double kNoise_m2 = 0.02 * 0.02;
  const double across_m2 = std::max(nd.eigenvalues_m2[2], 0.01 * nd.eigenvalues_m2[0]);
  return std::min(static_cast<double>(nd.point_count), kMostPoints) / (across_m2 + kNoise_m2);
}

using Group = std::tuple<CellKey, std::uint8_t>;  // a cube and a direction

std::vector<std::size_t> chosen_of(const NdtMap& nds, const ChooseNdsOptions& options,
                                   const PointGrid& route) {
  std::map<Group, std::vector<Candidate>> groups;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < nds.nds.size(); ++i) {
    const Nd& nd = nds.nds[i];
    const std::optional<NearPoint> site = route.nearest(nd.mean_m, options.far_m);
    if (!site) continue;
    if (site->distance_m <= options.near_m) {
      chosen.push_back(i);
      continue;
    }
    const Group group{cell_key(nd.mean_m, options.block_m), normal_class(nd.eigenvectors.col(2))};
    groups[group].push_back({i, worth_of(nd)});
  }
  for (auto& [group, members] : groups) {
    std::ranges::stable_sort(members, std::ranges::greater{}, &Candidate::worth);
    const std::size_t kept =
        std::min(members.size(), static_cast<std::size_t>(options.per_direction));
    for (std::size_t i = 0; i < kept; ++i) chosen.push_back(members[i].nd);
  }
  std::ranges::sort(chosen);
  return chosen;
}

NdtMap small_tile(const NdtMap& nds, const std::vector<std::size_t>& chosen) {
  NdtMap small{nds.frame, nds.cell_m, nds.tile_m, {}, 0, 0, 0};
  for (const std::size_t i : chosen) small.nds.push_back(rounded_small(nds.nds[i], nds.cell_m));
  decompose(std::span(small.nds));
  return small;
}

}  // namespace

std::vector<OptionField> option_fields(ChooseNdsOptions& options) {
  return {number("far_m", options.far_m, "farther from the route than this no ND is kept, m", 1.0,
                 1000.0),
          number("block_m", options.block_m, "edge of the cubes that keep NDs of each direction, m",
                 0.1, 1000.0),
          integer("per_direction", options.per_direction,
                  "NDs that such a cube keeps of each direction", 1, 1000000),
          number("near_m", options.near_m, "nearer to the route than this every ND is kept, m", 0.0,
                 1000.0)};
}

Result<TiledNds> choose_nds(PassContext& ctx, const ChooseNdsOptions& options, const TiledNds& nds,
                            const Sites& sites) {
  const PointGrid route(positions_m(sites), 16.0);
  NdtMap head = nds.head();
  StoredTableWriter<NdtMap> writer(head);
  std::uint64_t kept = 0;
  for (const RowTile& tile : nds.tiles()) {
    SIGHTLINE_ASSIGN(const NdtMap of_tile, nds.tile(tile));
    const NdtMap small = small_tile(of_tile, chosen_of(of_tile, options, route));
    kept += small.nds.size();
    SIGHTLINE_TRY(writer.append(small));
  }
  if (kept == 0) {
    return Error{ErrorCode::kEmptyMap,
                 concat("no ND is within ", format_double(options.far_m), " m of the route"), "",
                 "pass choose-nds"};
  }
  ctx.inform(concat("kept ", kept, " of ", nds.row_count(), " NDs"));
  return writer.take();
}

}  // namespace sightline
