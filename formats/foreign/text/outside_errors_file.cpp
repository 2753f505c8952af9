#include "formats/foreign/text/outside_errors_file.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <tuple>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

enum Column : std::size_t { kScan, kLook, kStart, kError, kColumnCount };
constexpr std::array<std::string_view, kColumnCount> kNames = {"scan", "look", "start", "error"};

using Words = std::vector<std::string_view>;
using Places = std::array<std::size_t, kColumnCount>;  // of each column among the words

Error error_at_line(ErrorCode code, const std::string& message, std::size_t line) {
  return {code, message, "", concat("line ", line)};
}

Error malformed(const std::string& message, std::size_t line) {
  return error_at_line(ErrorCode::kMalformedText, message, line);
}

std::optional<Column> column_named(std::string_view name) {
  if (name == "range" || name == "range_m" || name == "look_m") return kLook;
  if (name == "error_m") return kError;
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Column>(found - kNames.begin());
}

Result<Places> places_of(const Words& words, std::size_t line) {
  Places places;
  places.fill(words.size());
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::optional<Column> column = column_named(words[i]);
    if (!column) {
      return malformed(
          concat("found a column ", in_quotes(words[i]), ", expected scan, look, start and error"),
          line);
    }
    if (places[*column] != words.size()) {
      return malformed(concat("found the column ", kNames[*column], " twice"), line);
    }
    places[*column] = i;
  }
  const auto missing = std::ranges::find(places, words.size());
  if (missing == places.end()) return places;
  const auto column = static_cast<std::size_t>(missing - places.begin());
  return error_at_line(
      ErrorCode::kMissingField,
      concat("no column ", kNames[column], ": the first line names scan, look, start and error"),
      line);
}

Result<OutsideError> error_of(const Words& words, const Places& places, std::size_t line) {
  const auto bad = [&](Column column, const char* expected) {
    return malformed(concat("found ", kNames[column], " ", in_quotes(words[places[column]]),
                            ", expected ", expected),
                     line);
  };
  const auto scan = to_number<std::uint32_t>(words[places[kScan]]);
  if (!scan) return bad(kScan, "the index of a scan in the recording, counted from 0");
  const auto look_m = finite_number(words[places[kLook]]);
  if (!look_m || *look_m <= 0.0) return bad(kLook, "a distance above 0, m");
  const auto start = to_number<std::uint32_t>(words[places[kStart]]);
  if (!start) return bad(kStart, "the number of a start, counted from 0");
  const auto error_m = finite_number(words[places[kError]]);
  if (!error_m || *error_m < 0.0) return bad(kError, "a finite distance of at least 0 m");
  return OutsideError{*scan, *look_m, *start, *error_m, static_cast<std::uint32_t>(line)};
}

// By scan, look and start; the same twice is reported at the later line.
Result<void> sort_once(std::vector<OutsideError>& errors) {
  const auto key = [](const OutsideError& error) {
    return std::tuple(error.scan, error.range_m, error.start);
  };
  std::ranges::stable_sort(errors, {}, key);
  const auto twice = std::ranges::adjacent_find(errors, {}, key);
  if (twice == errors.end()) return {};
  const OutsideError& again = *(twice + 1);
  return malformed(concat("found scan ", again.scan, ", look ", format_double(again.range_m),
                          " m, start ", again.start, " again, as in line ", twice->line, " has"),
                   again.line);
}

Result<std::vector<OutsideError>> parse(std::string_view text) {
  LineReader lines(without_byte_order_mark(text));
  std::string_view line;
  std::optional<Places> places;
  std::vector<OutsideError> errors;
  while (lines.next(line)) {
    const std::string_view content = trimmed(line);
    if (content.empty() || content.starts_with('#')) continue;
    const Words words = cells_of(content, ',', " \t");
    if (!places) {
      SIGHTLINE_ASSIGN(places, places_of(words, lines.number()));
      continue;
    }
    if (words.size() != kColumnCount) {
      return malformed(concat("found ", words.size(), " columns, expected 4"), lines.number());
    }
    SIGHTLINE_ASSIGN(const OutsideError error, error_of(words, *places, lines.number()));
    errors.push_back(error);
  }
  if (errors.empty()) {
    return malformed("found no error, expected a line of names and one error a line",
                     lines.number());
  }
  SIGHTLINE_TRY(sort_once(errors));
  return errors;
}

}  // namespace

Result<std::vector<OutsideError>> read_outside_errors(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(path));
  Result<std::vector<OutsideError>> errors = parse(text);
  if (!errors) return in_file(errors.error(), path.string());
  return errors;
}

}  // namespace sightline
