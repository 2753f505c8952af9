#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/record/fields.h"
#include "formats/text/table.h"

// Facts and rows of tables from the fields of a record (record/fields.h). Numbers, texts, and enums
// by name are cells, a bool is 1 or 0, an optional without a value the empty text, what has a
// to_text() that text. Of records within a record come their own fields; vectors are left out.

namespace sightline {

template <class T>
concept HasText = requires(const T& value) {
  { to_text(value) } -> std::same_as<std::string>;
};

inline Cell cell_of(const std::string& text) { return text; }
template <class T>
requires std::is_arithmetic_v<T> Cell cell_of(T number) {
  if constexpr (std::is_floating_point_v<T>)
    return static_cast<double>(number);
  else
    return static_cast<std::int64_t>(number);
}
template <NamedEnum T>
Cell cell_of(T value) {
  return std::string(name_of(value));
}
template <HasText T>
Cell cell_of(const T& value) {
  return to_text(value);
}
template <class T>
Cell cell_of(const std::optional<T>& value) {
  return value ? cell_of(*value) : Cell(std::string());
}

// Calls use(name, cell) for each of its cells.
template <HasFields X, class Use>
void visit_cells(const X& record, const Use& use) {
  const auto visit = [&]<class T>(std::string_view name, const T& field) {
    if constexpr (requires { cell_of(field); }) {
      use(std::string(name), cell_of(field));
    } else if constexpr (HasFields<T>) {
      visit_cells(field, use);
    }
  };
  fields(visit, record);
}

// `prefix`: of the names.
template <HasFields X>
void append_facts(const X& record, Table& table, const std::string& prefix = "") {
  visit_cells(record, [&](const std::string& name, const Cell& cell) {
    table.facts.emplace_back(prefix + name, cell);
  });
}

template <HasFields X>
void append_columns(std::vector<std::string>& columns) {
  visit_cells(X(), [&](const std::string& name, const Cell&) { columns.push_back(name); });
}

template <HasFields X>
void append_cells(const X& record, std::vector<Cell>& row) {
  visit_cells(record, [&](const std::string&, Cell cell) { row.push_back(std::move(cell)); });
}

// A column for each field and a row for each record.
template <HasFields X>
Table table_of(std::string name, const std::vector<X>& records) {
  Table table{std::move(name), {}, {}, {}};
  append_columns<X>(table.columns);
  for (const X& record : records) append_cells(record, table.rows.emplace_back());
  return table;
}

}  // namespace sightline
