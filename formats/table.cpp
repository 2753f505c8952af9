#include "formats/table.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "formats/quoted_text.h"

namespace sightline {
namespace {

std::string plain(const Cell& cell) {
  if (const auto* number = std::get_if<std::int64_t>(&cell)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&cell)) return format_double(*number);
  return std::get<std::string>(cell);
}

std::string json_value(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return json_string(*text);
  if (const auto* number = std::get_if<double>(&cell); number && !std::isfinite(*number)) {
    return "null";
  }
  return plain(cell);
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
  for (const auto& [name, value] : table.facts) text += "# " + name + ": " + plain(value) + "\n";
  text += joined(table.columns, ",", csv_field) + "\n";
  for (const std::vector<Cell>& row : table.rows) {
    text += joined(row, ",", [](const Cell& cell) { return csv_field(plain(cell)); }) + "\n";
  }
  return text;
}

std::string to_json(const Table& table) {
  std::string text = "{\"name\": " + json_string(table.name) + ", \"facts\": {";
  text += joined(table.facts, ", ", [](const std::pair<std::string, Cell>& fact) {
    return json_string(fact.first) + ": " + json_value(fact.second);
  });
  text += "},\n \"columns\": [" + joined(table.columns, ", ", json_string) + "],\n \"rows\": [";
  text += joined(table.rows, ",", [](const std::vector<Cell>& row) {
    return "\n  [" + joined(row, ", ", json_value) + "]";
  });
  return text + "]}\n";
}

std::string to_aligned_text(const Table& table) {
  std::string text;
  for (const auto& [name, value] : table.facts) text += name + ": " + plain(value) + "\n";
  std::vector<std::vector<std::string>> lines = {table.columns};
  for (const std::vector<Cell>& row : table.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (const Cell& cell : row) line.push_back(plain(cell));
  }
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const std::vector<std::string>& line : lines) {
    for (std::size_t i = 0; i < line.size() && i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], line[i].size());
    }
  }
  for (const std::vector<std::string>& line : lines) {
    for (std::size_t i = 0; i < line.size() && i < widths.size(); ++i) {
      if (i > 0) text += "  ";
      text += std::string(widths[i] - line[i].size(), ' ') + line[i];
    }
    text += "\n";
  }
  return text;
}

}  // namespace

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
               "unknown format '" + std::string(name) + "', expected csv, json or text", "", ""};
}

}  // namespace sightline
