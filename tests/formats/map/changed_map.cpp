#include "tests/formats/map/changed_map.h"

#include <map>

#include "formats/base/random.h"

namespace sightline {
namespace {

void change_nds(NdtMap& ndt, Random& random) {
  std::map<std::pair<TileKey, CellKey>, Nd> sorted;
  for (Nd nd : ndt.nds) {
    const double what = random.uniform();
    if (what < 0.1) continue;
    if (what < 0.3) {
      const Eigen::Vector3d corner_m(nd.key.x, nd.key.y, nd.key.z);
      for (int axis = 0; axis < 3; ++axis) {
        nd.mean_m[axis] = ndt.cell_m * (corner_m[axis] + random.uniform(0.01, 0.99));
      }
    }
    sorted[{tile_of(nd.key, ndt.cell_m, ndt.tile_m), nd.key}] = nd;
    if (what < 0.9) continue;
    nd.mean_m.x() += ndt.cell_m * static_cast<double>(1 + random.below(40));
    nd.key = cell_key(nd.mean_m, ndt.cell_m);
    sorted.insert({{tile_of(nd.key, ndt.cell_m, ndt.tile_m), nd.key}, nd});
  }
  ndt.nds.clear();
  for (const auto& [key, nd] : sorted) ndt.nds.push_back(nd);
}

template <class T>
void erase_row(std::vector<T>& values, std::size_t row, std::size_t per_row) {
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(row * per_row);
  values.erase(begin, begin + static_cast<std::ptrdiff_t>(per_row));
}

void erase_site(PredictedError& predicted, std::size_t site) {
  const std::size_t looks = predicted.looks.size();
  erase_row(predicted.mean_m, site, looks);
  erase_row(predicted.within_probability, site, looks * predicted.limits_m.size());
  erase_row(predicted.extrapolated, site, looks);
  erase_row(predicted.out_of_fold, site, 1);
  erase_row(predicted.has_history, site, 1);
  --predicted.site_count;
}

void erase_site(RangeTable& ranges, std::size_t site) {
  erase_row(ranges.range_index, site, ranges.promises.size());
  erase_row(ranges.flags, site, ranges.promises.size());
  erase_row(ranges.reasons, site, ranges.promises.size());
  --ranges.site_count;
}

void erase_site(FactorTable& factors, std::size_t site) {
  erase_row(factors.values, site, factors.looks.size() * factors.factors.size());
  --factors.site_count;
}

void erase_site(CompiledMap& map, std::size_t site) {
  erase_row(map.sites.sites, site, 1);
  erase_site(map.predicted, site);
  erase_site(map.ranges, site);
  erase_site(map.factors, site);
  if (!map.looks) return;
  erase_site(map.looks->predicted, site);
  erase_site(map.looks->ranges, site);
  erase_site(map.looks->factors, site);
}

void change_ranges(CompiledMap& map, std::size_t site, Random& random) {
  const std::size_t limits = map.ranges.promises.size();
  std::uint64_t longest = map.ranges.looks.size() - 1;
  for (std::size_t limit = 0; limit < limits; ++limit) {
    longest = random.below(longest + 1);
    const bool is_longest = longest + 1 == map.ranges.looks.size();
    map.ranges.range_index[site * limits + limit] = static_cast<std::uint8_t>(longest);
    map.ranges.flags[site * limits + limit] =
        static_cast<std::uint8_t>((is_longest ? random.below(2) : 0) + 2 * random.below(2));
    map.ranges.reasons[site * limits + limit] = Reason::kDrives;
  }
}

// The first site stays: a run begins at s = 0 and a map has a site.
void change_sites(CompiledMap& map, Random& random) {
  for (std::size_t site = map.sites.sites.size(); site-- > 1;) {
    const double what = random.uniform();
    if (what < 0.1 && map.sites.sites[site].run == map.sites.sites[site - 1].run) {
      erase_site(map, site);
    } else if (what < 0.2) {
      map.sites.sites[site].p_map_m.x() += random.uniform(-15.0, 15.0);
    } else if (what < 0.4) {
      change_ranges(map, site, random);
    }
  }
}

}  // namespace

CompiledMap changed_map(const CompiledMap& map, std::uint64_t seed, bool moves_frame) {
  Random random(seed);
  CompiledMap changed = map;
  changed.release += 1;
  change_nds(changed.ndt, random);
  change_sites(changed, random);
  changed.quality = quality_of(changed.predicted, changed.ranges, nullptr);
  if (changed.looks) {
    auto& [predicted, ranges, quality, factors] = *changed.looks;
    quality = quality_of(predicted, ranges, nullptr);
  }
  if (!moves_frame) return changed;
  const Eigen::Vector3d shift_m(map.ndt.tile_m, -2.0 * map.ndt.tile_m, 0.0);
  const int cells = static_cast<int>(map.ndt.tile_m / map.ndt.cell_m);
  changed.ndt.frame.origin_world_m += shift_m;
  changed.sites.frame = changed.ndt.frame;
  for (Nd& nd : changed.ndt.nds) {
    nd.mean_m -= shift_m;
    nd.key.x -= cells;
    nd.key.y += 2 * cells;
  }
  for (Site& site : changed.sites.sites) {
    site.p_map_m -= shift_m;
    site.T_map_vehicle.translation() -= shift_m;
  }
  return changed;
}

}  // namespace sightline
