#include "passes/pass/options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "formats/text/table.h"

namespace sightline {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

Error bad_value(const OptionField& field, std::string_view found, const std::string& expected) {
  return {ErrorCode::kBadValue, concat(field.name, ": found '", found, "', expected ", expected)};
}

// " (metres)": of numbers, by the end of their name.
std::string unit_of(const OptionField& field) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kUnits = {
      {{"_m", "metres"}, {"_deg", "degrees"}, {"_s", "seconds"}, {"_hz", "a second"}}};
  for (const auto& [end, unit] : kUnits) {
    if (field.name.ends_with(end)) return concat(" (", unit, ")");
  }
  return "";
}

std::string interval(const OptionField& field) {
  return concat("a number in [", format_double(field.minimum), ", ", format_double(field.maximum),
                "]", unit_of(field));
}

// A number written with a decimal comma.
std::string hint_of_comma(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return "";
  return concat("; write decimals with a point: ", text.substr(0, comma), ".",
                text.substr(comma + 1));
}

template <class T>
bool parse_number(std::string_view text, T& number) {
  text = trimmed(text);
  const std::from_chars_result end =
      std::from_chars(text.data(), text.data() + text.size(), number);
  return end.ec == std::errc() && end.ptr == text.data() + text.size();
}

bool is_within(const OptionField& field, double number) {
  return std::isfinite(number) && number >= field.minimum && number <= field.maximum;
}

Result<void> set(const OptionField& field, bool* value, std::string_view text) {
  if (text != "true" && text != "false") return bad_value(field, text, "true or false");
  *value = text == "true";
  return {};
}

Result<void> set(const OptionField& field, int* value, std::string_view text) {
  int number = 0;
  if (!parse_number(text, number) || !is_within(field, number)) {
    return bad_value(field, text, "a whole number" + interval(field).substr(8));
  }
  *value = number;
  return {};
}

Result<void> set(const OptionField& field, double* value, std::string_view text) {
  double number = 0.0;
  if (!parse_number(text, number) || !is_within(field, number)) {
    return bad_value(field, text, interval(field) + hint_of_comma(text));
  }
  *value = number;
  return {};
}

Error unknown_choice(const OptionField& field, std::string_view text) {
  std::string expected = "one of";
  for (const std::string& known : field.choices) expected += " " + known;
  const std::string near = nearest_name(text, field.choices);
  if (!near.empty()) expected += concat("; did you mean ", near, "?");
  return bad_value(field, text, expected);
}

Result<void> set(const OptionField& field, std::string* value, std::string_view text) {
  const bool is_known = std::ranges::find(field.choices, text) != field.choices.end();
  if (!field.choices.empty() && !is_known) return unknown_choice(field, text);
  *value = text;
  return {};
}

Result<void> set(const OptionField& field, const EnumValue& value, std::string_view text) {
  const auto found = std::ranges::find(field.choices, text);
  if (found == field.choices.end()) return unknown_choice(field, text);
  value.set(static_cast<std::size_t>(found - field.choices.begin()));
  return {};
}

Result<void> set(const OptionField& field, std::vector<double>* value, std::string_view text) {
  std::string_view rest = text;
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  std::vector<double> list;
  while (true) {
    const std::size_t comma = rest.find(',');
    double number = 0.0;
    if (!parse_number(rest.substr(0, comma), number) || !is_within(field, number) ||
        (!list.empty() && number <= list.back())) {
      return bad_value(field, text, "an ascending list, each " + interval(field));
    }
    list.push_back(number);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  *value = list;
  return {};
}

constexpr std::string_view kPaper = "paper";  // looks at every return alone

Result<void> set(const OptionField& field, std::vector<Look>* value, std::string_view text) {
  if (text == kPaper) {
    value->clear();
    return {};
  }
  const Result<std::vector<Look>> looks = parse_looks(text);
  if (!looks) return bad_value(field, text, "paper, or looks; " + looks.error().message);
  if (std::ranges::any_of(*looks, takes_every_return)) {
    return bad_value(field, text,
                     "looks that take a sample, for example \"100 m, 1944 returns, 80 points\"; "
                     "list those that take every return in ranges_m");
  }
  for (std::size_t i = 1; i < looks->size(); ++i) {
    const Look& before = (*looks)[i - 1];
    const Look& here = (*looks)[i];
    if (expected_cost(here) >= expected_cost(before)) continue;
    return bad_value(field, text,
                     concat("looks in ascending order of matching time: '", to_text(here),
                            "' takes less time than '", to_text(before), "' before it"));
  }
  *value = *looks;
  return {};
}

std::string text_of(const OptionField&, const bool* value) { return *value ? "true" : "false"; }
std::string text_of(const OptionField&, const int* value) { return std::to_string(*value); }
std::string text_of(const OptionField&, const double* value) { return format_double(*value); }
std::string text_of(const OptionField&, const std::string* value) { return *value; }
std::string text_of(const OptionField& field, const EnumValue& value) {
  return field.choices.at(value.get());
}
std::string text_of(const OptionField&, const std::vector<Look>* value) {
  return value->empty() ? std::string(kPaper) : to_text(*value);
}
std::string text_of(const OptionField&, const std::vector<double>* value) {
  std::string text;
  for (const double number : *value) text += (text.empty() ? "" : ", ") + format_double(number);
  return text;
}

// Insertions, deletions, substitutions and swaps of two neighbours (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> least(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) least[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) least[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = least[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      least[i][j] = std::min({least[i - 1][j] + 1, least[i][j - 1] + 1, substituted});
      const bool is_swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_swap) least[i][j] = std::min(least[i][j], least[i - 2][j - 2] + 1);
    }
  }
  return least[a.size()][b.size()];
}

}  // namespace

Result<void> set_from_text(OptionField& field, std::string_view value) {
  return std::visit([&](auto& target) { return set(field, target, trimmed(value)); }, field.value);
}

std::string to_text(const OptionField& field) {
  return std::visit([&](const auto& value) { return text_of(field, value); }, field.value);
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& known) {
  std::string best;
  // Farther than a third of the word is a guess, not a typing error.
  std::size_t least = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace sightline
