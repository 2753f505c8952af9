#include "formats/text/table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formats/base/printable.h"
#include "formats/text/json_text.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json json_value(const Cell& cell) {
  return std::visit([](const auto& value) { return Json(value); }, cell);  // not finite: null
}

template <class T, class Format>
std::string joined(const std::vector<T>& items, std::string_view separator, Format format) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += separator;
    text += format(items[i]);
  }
  return text;
}

std::string to_csv(const Table& table) {
  std::string text;
  for (const auto& [name, value] : table.facts)
    text += concat("# ", one_line(name), ": ", one_line(cell_text(value)), "\n");
  text += joined(table.columns, ",", csv_field) + "\n";
  for (const std::vector<Cell>& row : table.rows) {
    text += joined(row, ",", [](const Cell& cell) { return csv_field(cell_text(cell)); }) + "\n";
  }
  return text;
}

// One line a row: a table may be larger than a tree of JSON values should be.
std::string to_json(const Table& table) {
  Json facts = Json::object();
  for (const auto& [name, value] : table.facts) facts[name] = json_value(value);
  std::string text =
      concat("{\"name\": ", json_text(table.name, -1), ", \"facts\": ", json_text(facts, -1));
  text += concat(",\n \"columns\": ", json_text(table.columns, -1), ",\n \"rows\": [");
  text += joined(table.rows, ",", [](const std::vector<Cell>& row) {
    Json cells = Json::array();
    for (const Cell& cell : row) cells.push_back(json_value(cell));
    return "\n  " + json_text(cells, -1);
  });
  return text + "]}\n";
}

std::string to_aligned_text(const Table& table) {
  std::string text;
  for (const auto& [name, value] : table.facts)
    text += concat(one_line(name), ": ", one_line(cell_text(value)), "\n");
  TextGrid grid = {table.columns};
  for (const std::vector<Cell>& row : table.rows) {
    std::vector<std::string>& line = grid.emplace_back();
    for (const Cell& cell : row) line.push_back(cell_text(cell));
  }
  return text + aligned(grid, FirstColumn::kRight);
}

}  // namespace

std::string cell_text(const Cell& cell) {
  if (const auto* number = std::get_if<std::int64_t>(&cell)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&cell)) return format_double(*number);
  return std::get<std::string>(cell);
}

std::string format_double(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[32];
  const std::to_chars_result end = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, end.ptr};
}

std::string format_table(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kCsv:
      return to_csv(table);
    case TableFormat::kJson:
      return to_json(table);
    case TableFormat::kText:
      return to_aligned_text(table);
  }
  return {};
}

Result<TableFormat> parse_table_format(std::string_view name) {
  if (name == "csv") return TableFormat::kCsv;
  if (name == "json") return TableFormat::kJson;
  if (name == "text") return TableFormat::kText;
  return Error{ErrorCode::kUnknownName,
               concat("unknown format '", name, "', expected csv, json or text")};
}

std::string aligned(const TextGrid& cells, FirstColumn first) {
  TextGrid grid = cells;
  std::vector<std::size_t> widths;
  for (std::vector<std::string>& row : grid) {
    for (std::string& cell : row) cell = one_line(cell);
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const std::vector<std::string>& row : grid) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      if (i > 0) text += "  ";
      text += i == 0 && first == FirstColumn::kLeft ? row[i] + space : space + row[i];
    }
    text += "\n";
  }
  return text;
}

}  // namespace sightline
