#include "compiler/views/exports/cells.h"

#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "compiler/views/exports/lane_answers.h"
#include "formats/record/cells.h"

namespace sightline {
namespace {

using ColumnPlace = std::pair<std::int64_t, std::int64_t>;

std::int64_t floored(double value) { return static_cast<std::int64_t>(std::floor(value)); }

// All that may lie within reach of a site.
Result<std::set<ColumnPlace>> cells_near(const MapReader& map, double cell_m) {
  SIGHTLINE_ASSIGN(const std::vector<MapSite> sites, map.sites(0));
  const double reach_m = map.info().reach_m;
  std::set<ColumnPlace> cells;
  for (const MapSite& site : sites) {
    const auto& [x_m, y_m, z_m] = site.position_world_m;
    for (std::int64_t x = floored((x_m - reach_m) / cell_m); x <= floored((x_m + reach_m) / cell_m);
         ++x) {
      for (std::int64_t y = floored((y_m - reach_m) / cell_m);
           y <= floored((y_m + reach_m) / cell_m); ++y) {
        cells.emplace(x, y);
      }
    }
  }
  return cells;
}

std::vector<std::string> columns_of(const MapInfo& info) {
  std::vector<std::string> columns = {"x_m", "y_m", "z_m", "site", "distance_m"};
  for (const double limit_m : info.limits_m) {
    const std::string within = concat("_within_", format_double(limit_m), "_m");
    for (const char* name : {"range_m", "p", "unmet", "reason"}) columns.push_back(name + within);
    if (info.looks.empty()) continue;
    for (const char* name : {"look", "look_p", "look_unmet", "look_reason"})
      columns.push_back(name + within);
  }
  return columns;
}

Cell is_unmet(std::uint32_t flags) { return std::int64_t{(flags & kAnswerUnmet) != 0 ? 1 : 0}; }

// Empty where the place has no answer.
Result<std::vector<Cell>> row_at(const MapReader& map, const std::array<double, 3>& p_m) {
  const MapInfo& info = map.info();
  std::vector<Cell> row;
  for (const double limit_m : info.limits_m) {
    SIGHTLINE_ASSIGN(const RangeAnswer range, map.observation_range(p_m, limit_m));
    if ((range.flags & kAnswerFar) != 0) return std::vector<Cell>();
    if (row.empty()) {
      row = {p_m[0], p_m[1], p_m[2], std::int64_t{range.site}, range.distance_m};
    }
    row.insert(row.end(),
               {range.range_m, range.probability, is_unmet(range.flags), cell_of(range.reason)});
    if (info.looks.empty()) continue;
    SIGHTLINE_ASSIGN(const LookAnswer look, map.look(p_m, limit_m));
    row.insert(row.end(), {to_text(look_of(look.look)), look.probability, is_unmet(look.flags),
                           cell_of(look.reason)});
  }
  return row;
}

}  // namespace

Result<Table> answers_by_cell(const MapReader& map, double cell_m) {
  SIGHTLINE_ASSIGN(const LaneAsker asker, LaneAsker::of(map, 0.0));
  SIGHTLINE_ASSIGN(const std::set<ColumnPlace> cells, cells_near(map, cell_m));
  Table table{"cells", columns_of(map.info()), {}, {}};
  for (const auto& [x, y] : cells) {
    const double x_m = (static_cast<double>(x) + 0.5) * cell_m;
    const double y_m = (static_cast<double>(y) + 0.5) * cell_m;
    for (const std::array<double, 3>& p_m : asker.levels_world_m(x_m, y_m)) {
      SIGHTLINE_ASSIGN(std::vector<Cell> row, row_at(map, p_m));
      if (!row.empty()) table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace sightline
