#include "compiler/views/text/table_rows.h"

#include <algorithm>

#include "compiler/views/picture/dump_picture.h"

namespace sightline {

Result<void> keep_site(int site, Table& table) {
  const auto column = std::ranges::find(table.columns, "site");
  if (column == table.columns.end()) {
    return Error{ErrorCode::kBadArgument, "--site: table '" + table.name + "' has no sites", "",
                 ""};
  }
  const auto index = static_cast<std::size_t>(column - table.columns.begin());
  std::erase_if(table.rows, [&](const std::vector<Cell>& row) {
    return row[index] != Cell(static_cast<std::int64_t>(site));
  });
  return {};
}

Result<void> keep_box(const std::string& text, Table& table) {
  SIGHTLINE_ASSIGN(const MapBox box, parse_box(text));
  const auto x = std::ranges::find(table.columns, "mean_x_m") - table.columns.begin();
  if (x == static_cast<long>(table.columns.size())) {
    return Error{ErrorCode::kBadArgument, "--box: only nds lie in boxes", "", ""};
  }
  const auto column = static_cast<std::size_t>(x);
  std::erase_if(table.rows, [&](const std::vector<Cell>& row) {
    return !box.contains({std::get<double>(row[column]), std::get<double>(row[column + 1]), 0.0});
  });
  return {};
}

}  // namespace sightline
