#include "formats/map/diff/diff_columns.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

// "mean 5.31 m", of the finite values.
std::string mean_text(const SiteColumn& column) {
  std::vector<double> finite;
  for (const float value : column.values) {
    if (std::isfinite(value)) finite.push_back(double{value});
  }
  const std::string mean =
      finite.empty() ? "none"
                     : format_double(ordered_sum(finite) / static_cast<double>(finite.size()));
  return "mean " + mean + (column.unit.empty() ? "" : " " + column.unit);
}

// Over places that both maps have.
struct Differences {
  std::size_t place_count = 0;
  std::size_t differing_count = 0;
  double largest = 0.0;
};

Result<Differences> compare_values(MapSide& before, MapSide& after, const SiteColumn& old_column,
                                   const SiteColumn& new_column) {
  const Eigen::Vector3d to_before_m =
      after.card().ndt.frame.origin_world_m - before.card().ndt.frame.origin_world_m;
  Differences differences;
  for (std::uint32_t tile = 0; tile < after.tile_count(); ++tile) {
    SIGHTLINE_ASSIGN(const TileSites* sites, after.sites(tile));
    for (const SiteRow& row : sites->rows) {
      SIGHTLINE_ASSIGN(const NearestSite nearest,
                       before.nearest(row.p_m + to_before_m, before.card().reach_m));
      const bool is_known = nearest.row != nullptr && row.site < new_column.values.size() &&
                            nearest.row->site < old_column.values.size();
      if (!is_known) continue;
      ++differences.place_count;
      const float was = old_column.values[nearest.row->site];
      const float is = new_column.values[row.site];
      if (was == is) continue;
      ++differences.differing_count;
      differences.largest = std::max(differences.largest, std::abs(double{is} - double{was}));
    }
  }
  return differences;
}

std::string differences_text(const Differences& differences, const std::string& unit) {
  return ", other at " + std::to_string(differences.differing_count) + " of " +
         std::to_string(differences.place_count) + " places, by at most " +
         format_double(differences.largest) + (unit.empty() ? "" : " " + unit);
}

Result<FactDiff> fact_of(MapSide& before, MapSide& after, const SiteColumn* old_card,
                         const SiteColumn* new_card) {
  FactDiff fact{"column." + (old_card != nullptr ? old_card : new_card)->name, "", ""};
  SiteColumn old_column;
  SiteColumn new_column;
  if (old_card != nullptr) {
    SIGHTLINE_ASSIGN(old_column, before.column(*old_card));
    fact.before = mean_text(old_column);
  }
  if (new_card == nullptr) return fact;
  SIGHTLINE_ASSIGN(new_column, after.column(*new_card));
  fact.after = mean_text(new_column);
  if (old_card == nullptr) return fact;
  SIGHTLINE_ASSIGN(const Differences differences,
                   compare_values(before, after, old_column, new_column));
  fact.after += differences_text(differences, new_column.unit);
  return fact;
}

const SiteColumn* find_column(const MapSide& side, const std::string& name) {
  const auto found = std::ranges::find(side.card().columns, name, &SiteColumn::name);
  return found == side.card().columns.end() ? nullptr : &*found;
}

}  // namespace

Result<std::vector<FactDiff>> diff_columns(MapSide& before, MapSide& after) {
  std::set<std::string> names;
  for (const MapSide* side : {&before, &after}) {
    for (const SiteColumn& column : side->card().columns) names.insert(column.name);
  }
  std::vector<FactDiff> facts;
  for (const std::string& name : names) {
    const SiteColumn* old_card = find_column(before, name);
    const SiteColumn* new_card = find_column(after, name);
    const bool has_both = old_card != nullptr && new_card != nullptr;
    if (has_both && before.column_digest(name) == after.column_digest(name) &&
        old_card->unit == new_card->unit) {
      continue;
    }
    SIGHTLINE_ASSIGN(FactDiff fact, fact_of(before, after, old_card, new_card));
    facts.push_back(std::move(fact));
  }
  return facts;
}

}  // namespace sightline
