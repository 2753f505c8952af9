#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/look.h"

// Options of a pass are a plain struct with default values beside the pass. From this description
// of its fields the configuration file, flags, JSON Schema and cache key are made:
//
//   struct BuildNdtOptions { double cell_m = 2.0; };
//   std::vector<OptionField> option_fields(BuildNdtOptions& options) {
//     return {number("cell_m", options.cell_m, "edge of a cell, m", 0.1, 100.0)};
//   }

namespace sightline {

// One of an enumeration that counts 0, 1, 2, ... in the order of OptionField::choices.
struct EnumValue {
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

using OptionValue = std::variant<bool*, int*, double*, std::string*, std::vector<double>*,
                                 std::vector<Look>*, EnumValue>;

struct OptionField {
  std::string name;  // as in the configuration file, unit included: "cell_m"
  OptionValue value;
  std::string help;
  double minimum = 0.0;  // of numbers, and of each element of a list
  double maximum = 0.0;
  std::vector<std::string> choices = {};  // of a string (empty: anything) or an enumeration
  // Set for all passes alike or by the plan, never in the pass's own section.
  bool is_shared = false;
};

// Marks fields that all passes share: `longest_range_m` is one value for a whole compile.
inline OptionField shared(OptionField field) {
  field.is_shared = true;
  return field;
}

inline OptionField flag(std::string name, bool& value, std::string help) {
  return {std::move(name), &value, std::move(help)};
}
inline OptionField integer(std::string name, int& value, std::string help, int minimum,
                           int maximum) {
  return {std::move(name), &value, std::move(help), static_cast<double>(minimum),
          static_cast<double>(maximum)};
}
inline OptionField number(std::string name, double& value, std::string help, double minimum,
                          double maximum) {
  return {std::move(name), &value, std::move(help), minimum, maximum};
}
// A list of numbers, ascending and without repetition.
inline OptionField numbers(std::string name, std::vector<double>& value, std::string help,
                           double minimum, double maximum) {
  return {std::move(name), &value, std::move(help), minimum, maximum};
}
// Looks that take a sample, as text from one to the next; none: "paper".
inline OptionField looks(std::string name, std::vector<Look>& value, std::string help) {
  return {std::move(name), &value, std::move(help)};
}
inline OptionField text(std::string name, std::string& value, std::string help) {
  return {std::move(name), &value, std::move(help)};
}
inline OptionField choice(std::string name, std::string& value, std::string help,
                          std::vector<std::string> choices) {
  return {std::move(name), &value, std::move(help), 0.0, 0.0, std::move(choices)};
}
// One of an enumeration whose values count 0, 1, 2, ... in the order of `choices`.
template <class E>
requires std::is_enum_v<E> OptionField choice(std::string name, E& value, std::string help,
                                              std::vector<std::string> choices) {
  const EnumValue chosen{[&value] { return static_cast<std::size_t>(value); },
                         [&value](std::size_t index) { value = static_cast<E>(index); }};
  return {std::move(name), chosen, std::move(help), 0.0, 0.0, std::move(choices)};
}

// Sets a field from text as it stands in YAML or on the command line ("2.0", "true", "10, 15").
// Error: bad-value, naming the field, what was found and what was expected.
Result<void> set_from_text(OptionField& field, std::string_view value);

// The value as text that set_from_text reads back exactly.
std::string to_text(const OptionField& field);

// The name in `known` at the least edit distance from `name`, or "" where none is near.
std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

}  // namespace sightline
