#include "compiler/views/text/table_rows.h"

#include <algorithm>
#include <iterator>

#include "compiler/views/picture/dump_picture.h"
#include "formats/base/check.h"
#include "formats/drive/look.h"

namespace sightline {
namespace {

void erase_column(std::size_t column, Table& table) {
  const auto offset = static_cast<std::ptrdiff_t>(column);
  table.columns.erase(table.columns.begin() + offset);
  for (std::vector<Cell>& row : table.rows) row.erase(row.begin() + offset);
}

bool is_sample(const Cell& look) {
  const Result<Look> read = parse_look(std::get<std::string>(look));
  return read && !takes_every_return(*read);
}

}  // namespace

Result<void> keep_site(int site, Table& table) {
  const auto column = std::ranges::find(table.columns, "site");
  if (column == table.columns.end()) {
    return Error{ErrorCode::kBadArgument, concat("--site: table '", table.name, "' has no sites")};
  }
  const auto index = static_cast<std::size_t>(column - table.columns.begin());
  std::erase_if(table.rows, [&](const std::vector<Cell>& row) {
    return row[index] != Cell(static_cast<std::int64_t>(site));
  });
  return {};
}

void append_world_columns(const MapFrame& frame, Table& table) {
  const auto x = std::ranges::find(table.columns, "p_x_m") - table.columns.begin();
  if (x == std::ssize(table.columns)) return;
  table.columns.insert(table.columns.end(), {"p_x_world_m", "p_y_world_m"});
  const auto column = static_cast<std::size_t>(x);
  for (std::vector<Cell>& row : table.rows) {
    const Eigen::Vector3d p_m =
        frame.world_m({std::get<double>(row[column]), std::get<double>(row[column + 1]), 0.0});
    row.emplace_back(p_m.x());
    row.emplace_back(p_m.y());
  }
}

Result<void> keep_box(const std::string& text, Table& table) {
  SIGHTLINE_ASSIGN(const MapBox box, parse_box(text));
  const auto x = std::ranges::find(table.columns, "mean_x_m") - table.columns.begin();
  if (x == static_cast<long>(table.columns.size())) {
    return Error{ErrorCode::kBadArgument, "--box needs --what nds"};
  }
  const auto column = static_cast<std::size_t>(x);
  std::erase_if(table.rows, [&](const std::vector<Cell>& row) {
    return !box.contains({std::get<double>(row[column]), std::get<double>(row[column + 1]), 0.0});
  });
  return {};
}

void keep_looks(KeptLooks kept, Table& table) {
  const auto found = std::ranges::find(table.columns, "look");
  if (found == table.columns.end()) return;
  const auto look = static_cast<std::size_t>(found - table.columns.begin());
  if (kept == KeptLooks::kSamples) table.name += kLooksSuffix;
  std::erase_if(table.rows, [&](const std::vector<Cell>& row) {
    return is_sample(row[look]) != (kept == KeptLooks::kSamples);
  });
  for (std::size_t column = table.columns.size(); column-- > 0;) {
    const bool says_nothing =
        !table.rows.empty() && std::ranges::all_of(table.rows, [&](const std::vector<Cell>& row) {
          return row[column] == Cell(std::string());
        });
    if (says_nothing || (column == look && kept == KeptLooks::kRanges)) erase_column(column, table);
  }
}

Table take_samples(Table& table) {
  const auto found = std::ranges::find(table.columns, "look");
  SIGHTLINE_CHECK(found != table.columns.end());
  const auto look = static_cast<std::size_t>(found - table.columns.begin());
  const auto first =
      std::stable_partition(table.rows.begin(), table.rows.end(),
                            [&](const std::vector<Cell>& row) { return !is_sample(row[look]); });
  Table samples{table.name, table.columns, {}, table.facts};
  samples.rows.assign(std::make_move_iterator(first), std::make_move_iterator(table.rows.end()));
  table.rows.erase(first, table.rows.end());
  keep_looks(KeptLooks::kSamples, samples);
  return samples;
}

}  // namespace sightline
