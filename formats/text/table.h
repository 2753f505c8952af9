#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// What every artifact can be printed as: named columns (units in the names) and rows of cells.
// A missing value is the empty string.
using Cell = std::variant<std::int64_t, double, std::string>;

// As CSV has it, without quotes.
std::string cell_text(const Cell& cell);

struct Table {
  std::string name;                  // "nds"
  std::vector<std::string> columns;  // "mean_x_m"
  std::vector<std::vector<Cell>> rows;
  // Single facts that belong to the whole, printed before the rows: {"cell_m", 2.0}.
  std::vector<std::pair<std::string, Cell>> facts;
};

enum class TableFormat { kCsv, kJson, kText };

// Doubles in the shortest decimal form that reads back as the same double; "inf", "-inf", "nan"
// (JSON: null). CSV per RFC 4180, facts as leading "# name: value" lines. JSON: {"name", "facts":
// {}, "columns": [], "rows": [[..]]}. Text: aligned columns for people, at the same precision. Ends
// in a newline.
std::string format_table(const Table& table, TableFormat format);

// "csv", "json", "text"; anything else is unknown-name.
Result<TableFormat> parse_table_format(std::string_view name);

// The shortest decimal form that reads back as the same double.
std::string format_double(double value);

// A table for people: [row][column]; rows may be short.
using TextGrid = std::vector<std::vector<std::string>>;

enum class FirstColumn { kLeft, kRight };

// The first column to the left (unless said), the others to the right, two spaces between, one line
// a row.
std::string aligned(const TextGrid& grid, FirstColumn first = FirstColumn::kLeft);

}  // namespace sightline
