#include "formats/map/diff/diff_facts.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "formats/base/parallel.h"
#include "formats/record/field_texts.h"

namespace sightline {
namespace {

using Facts = FieldTexts::Texts;

std::string digest_of(const SensorProfile& sensor) {
  ByteWriter writer;
  encode(sensor, writer);
  return to_hex(sha256(writer.bytes()));
}

void add_ndt(const NdtMap& ndt, FieldTexts& facts) {
  facts.add("cell_m", ndt.cell_m);
  facts.add("tile_m", ndt.tile_m);
  facts.add("point_count", ndt.point_count);
  facts.add("sparse_cell_count", ndt.sparse_cell_count);
  facts.add("degenerate_cell_count", ndt.degenerate_cell_count);
}

// `of`: "promise.", or "look_promise." of the looks that take a sample.
void add_promises(const RangeTable& ranges, const std::string& of, FieldTexts& facts) {
  for (const LimitPromise& promise : ranges.promises) {
    facts.add(concat(of, format_double(promise.limit_m), "_m"), promise);
  }
}

void add_choice(const CompiledMap& map, FieldTexts& facts) {
  std::vector<double> limits_m;
  for (const LimitPromise& promise : map.ranges.promises) limits_m.push_back(promise.limit_m);
  facts.add("ranges_m", ranges_of(map.ranges.looks));
  facts.add("limits_m", limits_m);
  facts.add("rule", map.ranges.selection);
  facts.add("dilation_m", map.ranges.dilation_m);
  facts.add("extrapolated_takes_static", map.ranges.extrapolated_takes_static);
  facts.add("support_margin", map.predicted.support_margin);
  add_promises(map.ranges, "promise.", facts);
}

// Of the looks that take a sample.
void add_looks(const CompiledMap& map, FieldTexts& facts) {
  if (!map.looks) return;
  const auto& [predicted, looks, quality, factors] = *map.looks;
  facts.add("looks", to_text(looks.looks));
  facts.add("look_plan", looks.plan ? to_text(*looks.plan) : "none");
  if (looks.plan) facts.add_fields("look_plan", *looks.plan);
  add_promises(looks, "look_promise.", facts);
  for (std::size_t limit = 0; limit < quality.size(); ++limit) {
    const std::string name =
        concat("look_coverage.", format_double(map.ranges.promises[limit].limit_m), "_m.");
    facts.add(name + "expected", quality[limit].expected_coverage);
    facts.add(name + "measured", quality[limit].measured_coverage);
  }
}

void add_model(const ModelRecord& model, FieldTexts& facts) {
  facts.add("model.encoding_version", model.encoding_version);
  facts.add("model.localizer", model.localizer);
  facts.add("model.digest", model.digest);
}

Facts facts_of(const CompiledMap& map) {
  FieldTexts facts;
  facts.add("map_id", map.map_id);
  facts.add("version", map.version);
  facts.add("release", map.release);
  facts.add("writer", map.writer);
  facts.add("frame", map.ndt.frame);
  facts.add("frame.world", map.world);
  add_ndt(map.ndt, facts);
  facts.add("site_spacing_m", map.sites.spacing_m);
  facts.add("reach_m", map.reach_m);
  facts.add("size", map.size);
  add_choice(map, facts);
  add_looks(map, facts);
  facts.add("sensor.name", map.sensor.name);
  facts.add("sensor.digest", digest_of(map.sensor));
  facts.add("measurement", map.measurement);
  for (const NamedVersion& definition : map.definitions) {
    facts.add("definitions." + definition.name, concat("v", definition.version));
  }
  add_model(map.model, facts);
  if (map.sharpness) {
    facts.add("sharpness", map.sharpness->of_map);
    facts.add("sharpness.of_given", map.sharpness->of_given);
  }
  facts.add("trajectory", map.trajectory);
  for (const Notice& notice : map.notices) facts.add("notice." + notice.code, notice.text);
  return facts.take();
}

const std::string* find(const Facts& facts, const std::string& name) {
  const auto found = std::find_if(facts.begin(), facts.end(),
                                  [&](const auto& fact) { return fact.first == name; });
  return found == facts.end() ? nullptr : &found->second;
}

// "mean 5.31 m", of the finite values.
std::string mean_text(const SiteColumn& column) {
  std::vector<double> finite;
  for (const float value : column.values) {
    if (std::isfinite(value)) finite.push_back(double{value});
  }
  const std::string mean =
      finite.empty() ? "none"
                     : format_double(ordered_sum(finite) / static_cast<double>(finite.size()));
  return concat("mean ", mean, (column.unit.empty() ? "" : " " + column.unit));
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
      SIGHTLINE_ASSIGN(
          const NearestSite nearest,
          before.nearest(row.p_m + to_before_m, before.card().reach_m, MapSide::Level::kSame));
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
  return concat(", different at ", differences.differing_count, " of ", differences.place_count,
                " places, by at most ", format_double(differences.largest),
                (unit.empty() ? "" : " " + unit));
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

std::vector<FactDiff> diff_facts(const CompiledMap& before, const CompiledMap& after) {
  const Facts old_facts = facts_of(before);
  const Facts new_facts = facts_of(after);
  std::vector<FactDiff> changes;
  for (const auto& [name, value] : old_facts) {
    const std::string* now = find(new_facts, name);
    if (now == nullptr || *now != value) {
      changes.push_back({name, value, now == nullptr ? "" : *now});
    }
  }
  for (const auto& [name, value] : new_facts) {
    if (find(old_facts, name) == nullptr) changes.push_back({name, "", value});
  }
  return changes;
}

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
