#include "compiler/views/exports/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "compiler/views/exports/lane_answers.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

double number(const Table& table, std::size_t row, const std::string& column) {
  const auto at = std::ranges::find(table.columns, column) - table.columns.begin();
  const Cell& cell = table.rows[row][static_cast<std::size_t>(at)];
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) return static_cast<double>(*whole);
  return std::get<double>(cell);
}

// Heights of sensors over a place: that of the nearest site, and of those at most 2 m farther away
// on other levels.
std::vector<double> levels_at(const CompiledMap& map, double x_m, double y_m) {
  std::vector<std::pair<double, double>> sites;  // distance, height
  for (const Site& site : map.sites.sites) {
    const Eigen::Vector3d site_m = site.p_map_m + map.sites.frame.origin_world_m;
    const double distance_m = std::hypot(site_m.x() - x_m, site_m.y() - y_m);
    if (distance_m <= map.reach_m) sites.emplace_back(distance_m, site_m.z());
  }
  std::ranges::sort(sites);
  std::vector<double> levels_m;
  for (const auto& [distance_m, z_m] : sites) {
    const bool is_known = std::ranges::any_of(
        levels_m, [&, z = z_m](double level_m) { return std::abs(level_m - z) < 1.0; });
    if (!is_known && distance_m <= sites.front().first + 2.0) levels_m.push_back(z_m);
  }
  return levels_m;
}

TEST(Cells, EachIsWhatTheReaderAnswersAtItsCentreAndNoneIsMissing) {
  const CompiledMap map = random_map({.seed = 2, .site_count = 12, .extent_m = 20.0});
  const std::vector<std::byte> bytes = encode_map(map);
  const MapReader of_nobody = *MapReader::open(bytes, "");
  const MapReader reader = *MapReader::open(bytes, of_nobody.info().localizer);
  const double cell_m = 2.5;
  const Table table = value_of(answers_by_cell(reader, cell_m));
  const Eigen::Vector3d& origin_m = map.sites.frame.origin_world_m;
  std::size_t row = 0;
  for (double x_m = origin_m.x() - 50.0 + cell_m / 2.0; x_m < origin_m.x() + 50.0; x_m += cell_m) {
    for (double y_m = origin_m.y() - 52.0; y_m < origin_m.y() + 50.0; y_m += 0.25) {
      if (std::abs(std::remainder(y_m - cell_m / 2.0, cell_m)) > 1e-9) continue;
      for (const double z_m : levels_at(map, x_m, y_m)) {
        const RangeAnswer range = *reader.observation_range({x_m, y_m, z_m}, 0.25);
        if ((range.flags & kAnswerFar) != 0) continue;
        const LookAnswer look = *reader.look({x_m, y_m, z_m}, 0.25);
        ASSERT_LT(row, table.rows.size());
        EXPECT_EQ(number(table, row, "x_m"), x_m);
        EXPECT_EQ(number(table, row, "y_m"), y_m);
        EXPECT_EQ(number(table, row, "z_m"), z_m);
        EXPECT_EQ(number(table, row, "site"), range.site);
        EXPECT_EQ(number(table, row, "range_m_within_0.25_m"), range.range_m);
        EXPECT_EQ(number(table, row, "p_within_0.25_m"), range.probability);
        EXPECT_EQ(number(table, row, "unmet_within_0.25_m"), range.flags & kAnswerUnmet ? 1 : 0);
        const auto reason = std::ranges::find(table.columns, "reason_within_0.25_m");
        EXPECT_EQ(table.rows[row][static_cast<std::size_t>(reason - table.columns.begin())],
                  Cell{std::string(name_of(range.reason))});
        EXPECT_EQ(number(table, row, "look_p_within_0.25_m"), look.probability);
        const std::vector<Cell>& cells = table.rows[row++];
        EXPECT_EQ(std::count(cells.begin(), cells.end(), Cell(to_text(look_of(look.look)))) > 0,
                  true);
      }
    }
  }
  EXPECT_EQ(row, table.rows.size());
  EXPECT_GT(row, 100U);
  for (const std::vector<Cell>& cells : table.rows) EXPECT_EQ(cells.size(), table.columns.size());
}

}  // namespace
}  // namespace sightline
