#include "formats/foreign/clouds/floats/float_columns.h"

#include <algorithm>
#include <vector>

#include "formats/foreign/clouds/points/point_times.h"
#include "formats/foreign/text/field_names.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

constexpr std::size_t kLeastColumns = 3;
constexpr std::size_t kMostColumns = 64;

Error bad_columns(const std::string& what) {
  return {ErrorCode::kBadValue,
          "columns: " + what +
              ", expected how many floats a point has (3 to 64) or their names with x, y and z "
              "among them, such as x y z intensity ring"};
}

Result<FloatColumns> named_columns(const std::vector<std::string_view>& names) {
  FloatColumns columns{names.size(), {0, 0, 0}, std::nullopt, std::nullopt};
  std::array<bool, 3> has = {false, false, false};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    const bool is_repeated = std::find(names.begin(), names.begin() + static_cast<long>(i), name) !=
                             names.begin() + static_cast<long>(i);
    const bool is_second = (is_intensity_name(name) && columns.intensity) ||
                           (is_time_name(name) && columns.time) || (is_repeated && name != "_");
    if (is_second) return bad_columns("found a second " + in_quotes(name));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (name != std::string_view("xyz").substr(axis, 1)) continue;
      columns.position[axis] = i;
      has[axis] = true;
    }
    if (is_intensity_name(name)) columns.intensity = i;
    if (is_time_name(name)) columns.time = i;
  }
  if (!has[0] || !has[1] || !has[2]) return bad_columns("found no x, y or z");
  return columns;
}

}  // namespace

FloatColumns columns_of_count(std::size_t count) {
  FloatColumns columns;
  columns.count = count;
  if (count == kLeastColumns) columns.intensity.reset();
  return columns;
}

Result<FloatColumns> parse_float_columns(std::string_view text) {
  std::vector<std::string_view> words;
  split_words(text, words, " \t\r\n,");
  if (words.size() == 1) {
    const std::optional<std::size_t> count = to_number<std::size_t>(words.front());
    if (!count || *count < kLeastColumns || *count > kMostColumns) {
      return bad_columns("found " + in_quotes(text));
    }
    return columns_of_count(*count);
  }
  if (words.size() > kMostColumns) {
    return bad_columns("found " + std::to_string(words.size()) + " names");
  }
  return named_columns(words);
}

std::string to_text(const FloatColumns& columns) {
  std::string text;
  for (std::size_t i = 0; i < columns.count; ++i) {
    std::string name = "_";
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (columns.position[axis] == i) name = std::string_view("xyz").substr(axis, 1);
    }
    if (columns.intensity == i) name = "intensity";
    if (columns.time == i) name = "time";
    text += (text.empty() ? "" : " ") + name;
  }
  return text;
}

}  // namespace sightline
