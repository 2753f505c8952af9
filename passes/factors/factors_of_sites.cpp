#include "passes/factors/factors_of_sites.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/tables/stored_table_writer.h"
#include "passes/factors/compute_factors.h"
#include "passes/pass/tile_digests.h"
#include "passes/pass/work_in_parts.h"

namespace sightline {
namespace {

// Prefixed, since both kinds of rays have a length.
void append_shared(const std::string& prefix, std::vector<OptionField> fields,
                   std::vector<OptionField>& all) {
  for (OptionField& field : fields) {
    field.name = prefix + field.name;
    all.push_back(shared(std::move(field)));
  }
}

Sites sites_of(const SiteBlock& block, const Sites& all) {
  Sites sites;
  sites.frame = all.frame;
  sites.spacing_m = all.spacing_m;
  for (const std::size_t site : block.sites) sites.sites.push_back(all.sites[site]);
  return sites;
}

struct BlockRows {
  std::uint64_t point_count = 0;
  std::uint64_t unmatched_count = 0;
  std::vector<double> values;  // [site][range][factor]
};
SIGHTLINE_FIELDS(BlockRows, point_count, unmatched_count, values)

// Of all that sites may see or be matched to.
struct ContentDigests {
  TileDigests nds;
  TileDigests patches;
};

class BlockFactors {
 public:
  BlockFactors(const FactorsOfSitesOptions& options, const TiledNds& nds,
               const TiledSurface& surface, ContentDigests digests, const Sites& sites,
               const SensorProfile& sensor)
      : options_(options),
        nds_(nds),
        sites_(sites),
        sensor_(sensor),
        caster_(surface, sites,
                std::max(options.rays.longest_range_m, options.scans.longest_range_m)),
        digests_(std::move(digests)) {}

  [[nodiscard]] const std::vector<SiteBlock>& blocks() const { return caster_.blocks(); }

  [[nodiscard]] Result<SeenFactors> see(const SiteBlock& block, int threads) const {
    SIGHTLINE_ASSIGN(const BlockScene scene, caster_.scene(block));
    SIGHTLINE_ASSIGN(const DepthImages depth,
                     cast_rays_in_block(options_.rays, scene, sensor_, threads));
    SIGHTLINE_ASSIGN(const VirtualScans scans,
                     cast_scans_in_block(options_.scans, scene, sensor_, threads));
    const Sites sites = sites_of(block, sites_);
    // What a localizer needs of a whole street would be twenty times its NDs.
    SIGHTLINE_ASSIGN(const NdtMap near, nds_.over(reach_of_m(sites)));
    SIGHTLINE_ASSIGN(const FactorWorld world, make_factor_world(near, options_.ranges_m));
    PassContext ctx;
    ctx.threads = threads;
    return compute_factors(ctx, world, sites, depth, scans);
  }

  // Of the sites, the sensor and all that they may see or be matched to.
  [[nodiscard]] Digest content(const SiteBlock& block) const {
    ByteWriter writer;
    encode(sensor_, writer);
    std::vector<Eigen::Vector3d> places_m;
    const Sites sites = sites_of(block, sites_);
    for (const Site& site : sites.sites) {
      put_place(site, writer);
      places_m.push_back(site.p_map_m);
    }
    const double cast_m = std::max(options_.rays.longest_range_m, options_.scans.longest_range_m);
    DigestBuilder builder;
    builder.add(writer.bytes());
    builder.add(digests_.patches.within(box_around(places_m, cast_m + kBesidePatches_m)));
    builder.add(digests_.nds.within(reach_of_m(sites)));
    return builder.finish();
  }

 private:
  static constexpr double kBesidePatches_m = 8.0;  // more than half a patch

  // The plane on whose NDs the factors of sites depend.
  [[nodiscard]] Eigen::AlignedBox2d reach_of_m(const Sites& sites) const {
    const double longest_m = std::max(options_.ranges_m.back(), options_.scans.longest_range_m);
    const Eigen::Vector2d reach_m =
        Eigen::Vector2d::Constant(longest_m + kFarthestFound_m + 4.0 * nds_.head().cell_m);
    Eigen::AlignedBox2d box_m;
    for (const Site& site : sites.sites) {
      box_m.extend(site.p_map_m.head<2>() - reach_m);
      box_m.extend(site.p_map_m.head<2>() + reach_m);
    }
    return box_m;
  }

  const FactorsOfSitesOptions& options_;
  const TiledNds& nds_;
  const Sites& sites_;
  const SensorProfile& sensor_;
  SiteCaster caster_;
  ContentDigests digests_;
};

// No sites: what a table of any sites says of its columns. Error: mismatched-inputs.
Result<FactorTable> table_without_sites(const PassContext& ctx,
                                        const FactorsOfSitesOptions& options, const TiledNds& nds,
                                        const Sites& sites) {
  SIGHTLINE_ASSIGN(const NdtMap nowhere, nds.over(Eigen::AlignedBox2d()));
  SIGHTLINE_ASSIGN(const FactorWorld world, make_factor_world(nowhere, options.ranges_m));
  Sites none;
  none.frame = sites.frame;
  DepthImages depth;
  depth.longest_range_m = options.rays.longest_range_m;
  VirtualScans scans;
  scans.longest_range_m = options.scans.longest_range_m;
  SIGHTLINE_ASSIGN(SeenFactors seen, compute_factors(ctx, world, none, depth, scans));
  return std::move(seen.table);
}

}  // namespace

std::vector<OptionField> option_fields(FactorsOfSitesOptions& options) {
  std::vector<OptionField> fields = {
      shared(numbers("ranges_m", options.ranges_m, "observation ranges, m", 1.0, 1000.0))};
  append_shared("rays_", option_fields(options.rays), fields);
  append_shared("scans_", option_fields(options.scans), fields);
  return fields;
}

Result<StoredTable<FactorTable>> factors_of_sites(PassContext& ctx,
                                                  const FactorsOfSitesOptions& options,
                                                  const TiledNds& nds, const TiledSurface& surface,
                                                  const Sites& sites, const SensorProfile& sensor) {
  if (surface.head().frame != sites.frame) {
    return Error{ErrorCode::kMismatchedInputs, "surface and sites are in different frames", "",
                 "pass compute-factors"};
  }
  SIGHTLINE_ASSIGN(const FactorTable columns, table_without_sites(ctx, options, nds, sites));
  FactorTable head = columns;
  head.site_count = static_cast<std::uint32_t>(sites.sites.size());
  const SiteShape shape = head.shape();
  StoredTableWriter<FactorTable> writer(head);
  SIGHTLINE_ASSIGN(TileDigests nd_digests, digests_of(nds));
  SIGHTLINE_ASSIGN(TileDigests patch_digests, digests_of(surface));
  const BlockFactors factors(options, nds, surface,
                             {std::move(nd_digests), std::move(patch_digests)}, sites, sensor);
  std::vector<BlockRows> counts(factors.blocks().size());  // without values
  // The views of few blocks at a time are in memory. Of two one is made ready while the other's
  // sites are at work.
  const int blocks_at_once = std::min(2, threads_each(ctx.threads, 1));
  RecordWork<BlockRows> work;
  work.count = factors.blocks().size();
  work.content = [&](std::size_t part) { return factors.content(factors.blocks()[part]); };
  work.make = [&](std::size_t part, int threads) -> Result<BlockRows> {
    SIGHTLINE_ASSIGN(SeenFactors seen, factors.see(factors.blocks()[part], threads));
    return BlockRows{seen.point_count, seen.unmatched_count, std::move(seen.table.values)};
  };
  work.take = [&](std::size_t part, BlockRows rows) {
    const std::vector<std::size_t>& members = factors.blocks()[part].sites;
    if (rows.values.size() != shape.size(members.size())) return false;
    FactorTable of_members = columns;
    of_members.site_count = static_cast<std::uint32_t>(members.size());
    of_members.values = std::move(rows.values);
    writer.put(members, of_members);
    counts[part] = {rows.point_count, rows.unmatched_count, {}};
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work, blocks_at_once));
  BlockRows sum;
  for (const BlockRows& rows : counts) {
    sum.point_count += rows.point_count;
    sum.unmatched_count += rows.unmatched_count;
  }
  if (sum.unmatched_count > 0) {
    ctx.inform(concat(sum.unmatched_count, " of ", sum.point_count,
                      " virtual points are outside valid NDT cells and are ignored"));
  }
  return writer.take();
}

}  // namespace sightline
