#include <array>
#include <optional>

#include "formats/foreign/lanes/route_parsers.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

// Which word of a row is what; nothing: there is no such column.
struct Columns {
  std::size_t x = 0, y = 1;
  std::optional<std::size_t> z;
  std::optional<std::size_t> line;
  std::size_t count = 0;  // 0: not known yet
};

// A row of names. Error: missing-field.
Result<Columns> columns_of_head(const RouteText& file, const std::vector<std::string_view>& words) {
  Columns columns;
  columns.count = words.size();
  std::optional<std::size_t> x, y;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "x" || words[i] == "x_m") x = i;
    if (words[i] == "y" || words[i] == "y_m") y = i;
    if (words[i] == "z" || words[i] == "z_m") columns.z = i;
    if (words[i] == "line" || words[i] == "lane") columns.line = i;
  }
  if (!x || !y) {
    return file.error(ErrorCode::kMissingField, "expected columns x and y, and z or none",
                      "line 1");
  }
  columns.x = *x;
  columns.y = *y;
  return columns;
}

// Rows of numbers alone: x y, or x y z.
Result<Columns> columns_of_numbers(const RouteText& file, std::size_t count,
                                   const std::string& place) {
  if (count != 2 && count != 3) {
    return file.error(ErrorCode::kMalformedText,
                      "found " + std::to_string(count) +
                          " columns without a head that names them, expected x, y and z or none",
                      place);
  }
  Columns columns;
  columns.count = count;
  if (count == 3) columns.z = 2;
  return columns;
}

Result<Eigen::Vector3d> point_of(const RouteText& file, const Columns& columns,
                                 const std::vector<std::string_view>& words,
                                 const std::string& place) {
  if (words.size() != columns.count) {
    return file.error(ErrorCode::kMalformedText,
                      "found " + std::to_string(words.size()) + " columns, expected " +
                          std::to_string(columns.count),
                      place);
  }
  const std::array<std::optional<std::size_t>, 3> of_axis = {columns.x, columns.y, columns.z};
  Eigen::Vector3d point_m(0.0, 0.0, kNoHeight);
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<std::size_t> column = of_axis[static_cast<std::size_t>(axis)];
    if (!column) continue;
    const std::optional<double> number = to_number<double>(words[*column]);
    if (!number || !std::isfinite(*number)) {
      return file.error(ErrorCode::kMalformedText,
                        "found " + in_quotes(words[*column]) + ", expected a number", place);
    }
    point_m[axis] = *number;
  }
  if (!is_place(point_m)) {
    return file.error(ErrorCode::kMalformedText, "a place that far away is none on Earth", place);
  }
  return point_m;
}

// Lines as they come: points are gathered until the next one begins.
class LineGatherer {
 public:
  explicit LineGatherer(Route& route) : route_(route) {}
  void add(std::string_view key, const Eigen::Vector3d& point_m) {
    if (key != key_) end();
    key_ = key;
    points_m_.push_back(point_m);
  }
  void end() {
    RouteLine line = line_of_points("line " + std::to_string(++count_), points_m_);
    if (line.points_world_m.size() > 1) route_.lines.push_back(std::move(line));
    if (points_m_.empty()) --count_;
    points_m_.clear();
  }

 private:
  Route& route_;
  std::string key_;
  std::vector<Eigen::Vector3d> points_m_;
  std::size_t count_ = 0;
};

}  // namespace

Result<void> parse_csv_lines(const RouteText& file, Route& route) {
  constexpr std::string_view kSeparators = ",; \t\"";
  Columns columns;
  LineGatherer gatherer(route);
  LineReader lines(file.text);
  std::vector<std::string_view> words;
  for (std::string_view text; lines.next(text);) {
    const std::string place = "line " + std::to_string(lines.number());
    if (text.starts_with('#')) continue;
    split_words(text, words, kSeparators);
    if (words.empty()) {
      gatherer.end();
      continue;
    }
    if (columns.count == 0) {
      const bool is_head = !to_number<double>(words.front());
      SIGHTLINE_ASSIGN(columns, is_head ? columns_of_head(file, words)
                                        : columns_of_numbers(file, words.size(), place));
      if (is_head) continue;
    }
    SIGHTLINE_ASSIGN(const Eigen::Vector3d point_m, point_of(file, columns, words, place));
    gatherer.add(columns.line ? words[*columns.line] : std::string_view(), point_m);
  }
  gatherer.end();
  return {};
}

}  // namespace sightline
