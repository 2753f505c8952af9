#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "formats/foreign/clouds/cloud_parsers.h"
#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/text/text_lines.h"

// PLY is read here and not by PCL: its PLY reader takes a damaged file for an empty one, and rounds
// doubles. Elements behind the vertices are walked through as well, since only then is it known
// that the file is whole.

namespace sightline {
namespace {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };  // as read_format() names them

struct PlyProperty {
  std::string name;
  ElementType type;
  bool is_list = false;
  ElementType count_type;  // of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  std::size_t data_offset = 0;  // bytes
  std::size_t lines = 0;        // of the header
};

std::optional<ElementType> type_named(std::string_view name) {
  struct Known {
    std::string_view name;
    ElementType type;
  };
  using enum ElementKind;
  static constexpr Known kKnown[] = {
      {"char", {kSigned, 1}},     {"int8", {kSigned, 1}},     {"uchar", {kUnsigned, 1}},
      {"uint8", {kUnsigned, 1}},  {"short", {kSigned, 2}},    {"int16", {kSigned, 2}},
      {"ushort", {kUnsigned, 2}}, {"uint16", {kUnsigned, 2}}, {"int", {kSigned, 4}},
      {"int32", {kSigned, 4}},    {"uint", {kUnsigned, 4}},   {"uint32", {kUnsigned, 4}},
      {"float", {kFloat, 4}},     {"float32", {kFloat, 4}},   {"double", {kFloat, 8}},
      {"float64", {kFloat, 8}},   {"bool", {kUnsigned, 1}},  // not in the standard, but written
  };
  for (const Known& known : kKnown) {
    if (known.name == name) return known.type;
  }
  return std::nullopt;
}

Error malformed(const FileBytes& file, std::size_t line, std::string message) {
  return file.error(ErrorCode::kMalformedHeader, std::move(message), at_line(line));
}

Result<void> read_format(const FileBytes& file, std::size_t line,
                         const std::vector<std::string_view>& words, PlyHeader& header) {
  const std::string_view name = words.size() == 3 && words[2] == "1.0" ? words[1] : "";
  constexpr std::string_view kNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};
  const auto* found = std::ranges::find(kNames, name);
  if (found == std::end(kNames)) {
    return malformed(file, line,
                     "expected format ascii, binary_little_endian or "
                     "binary_big_endian, version 1.0");
  }
  header.encoding = static_cast<PlyEncoding>(found - kNames);
  return {};
}

Result<void> read_element_line(const FileBytes& file, std::size_t line,
                               const std::vector<std::string_view>& words, PlyHeader& header) {
  const std::optional<std::uint64_t> count =
      words.size() == 3 ? to_number<std::uint64_t>(words[2]) : std::nullopt;
  if (!count) return malformed(file, line, "expected 'element NAME COUNT'");
  header.elements.push_back({std::string(words[1]), *count, {}});
  return {};
}

Result<void> read_property(const FileBytes& file, std::size_t line,
                           const std::vector<std::string_view>& words, PlyHeader& header) {
  if (header.elements.empty()) return malformed(file, line, "a property before any element");
  const bool is_list = words.size() == 5 && words[1] == "list";
  const std::optional<ElementType> count_type =
      is_list ? type_named(words[2]) : std::optional<ElementType>(ElementType{});
  const std::optional<ElementType> type = is_list             ? type_named(words[3])
                                          : words.size() == 3 ? type_named(words[1])
                                                              : std::nullopt;
  if (!type || !count_type || (is_list && count_type->kind == ElementKind::kFloat)) {
    return malformed(file, line,
                     "expected 'property TYPE NAME' or 'property list TYPE TYPE NAME' "
                     "of known types");
  }
  header.elements.back().properties.push_back(
      {std::string(words.back()), *type, is_list, *count_type});
  return {};
}

Result<void> read_header_line(const FileBytes& file, std::size_t line,
                              const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return {};
  if (words[0] == "format") return read_format(file, line, words, header);
  if (words[0] == "element") return read_element_line(file, line, words, header);
  if (words[0] == "property") return read_property(file, line, words, header);
  return malformed(file, line, "expected a keyword of a PLY header");
}

// Errors: malformed-header with the line, truncated-scan where the file ends before end_header.
Result<PlyHeader> parse_ply_header(const FileBytes& file) {
  PlyHeader header;
  LineReader reader(file.text());
  std::string_view line;
  std::vector<std::string_view> words;
  bool has_format = false;
  while (reader.next(line) && reader.last_has_end()) {
    if (reader.number() == 1 && line == "ply") continue;
    if (reader.number() == 1) return malformed(file, 1, "expected 'ply' in the first line");
    split_words(line, words);
    if (!words.empty() && words[0] == "end_header") {
      if (!has_format) return malformed(file, reader.number(), "the header names no format");
      header.data_offset = reader.offset();
      header.lines = reader.number();
      return header;
    }
    SIGHTLINE_TRY(read_header_line(file, reader.number(), words, header));
    const bool is_format = !words.empty() && words[0] == "format";
    if (is_format && has_format) return malformed(file, reader.number(), "a second format");
    has_format = has_format || is_format;
  }
  return file.error(ErrorCode::kTruncatedScan, "the file ends before end_header",
                    at_byte(file.bytes.size()));
}

// Where x, y, z, intensity and time stand among the properties of a vertex; -1: nowhere.
struct VertexLayout {
  std::array<std::ptrdiff_t, 3> position = {-1, -1, -1};
  std::ptrdiff_t intensity = -1;
  std::ptrdiff_t time = -1;
  TimeName time_name;
};

Result<VertexLayout> vertex_layout(const FileBytes& file, const PlyHeader& header) {
  VertexLayout layout;
  std::size_t vertex_elements = 0;
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    if (++vertex_elements > 1) return malformed(file, header.lines, "a second element vertex");
    if (element.count == 0) {
      return file.error(ErrorCode::kEmptyScan, "the header has a count of 0 points",
                        at_line(header.lines));
    }
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (property.is_list) continue;
      const auto place = static_cast<std::ptrdiff_t>(i);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (property.name != std::string_view("xyz").substr(axis, 1)) continue;
        if (layout.position[axis] >= 0) {
          return malformed(file, header.lines, "a second property " + property.name);
        }
        layout.position[axis] = place;
      }
      if (is_intensity_name(property.name)) layout.intensity = place;
      if (layout.time_name.take(property.name)) layout.time = place;
    }
  }
  if (std::ranges::min(layout.position) < 0) {
    return file.error(ErrorCode::kMissingField, "no element vertex with properties x, y and z",
                      at_line(header.lines));
  }
  return layout;
}

// Numbers one after the other, whatever the encoding. Lists are counted and dropped.
class PlyBody {
 public:
  PlyBody(const FileBytes& file, const PlyHeader& header)
      : file_(file),
        encoding_(header.encoding),
        offset_(header.data_offset),
        lines_(file.text(), header.data_offset, header.lines) {}

  // The numbers of one row of an element; lists stand as 0 to keep places.
  Result<void> read_row(const PlyElement& element, std::vector<double>& row) {
    if (encoding_ == PlyEncoding::kAscii && !next_line()) return cut(element);
    row.clear();
    for (const PlyProperty& property : element.properties) {
      double value = 0.0;
      if (!read(property.is_list ? property.count_type : property.type, value)) return cut(element);
      if (property.is_list) {
        if (!skip(value, property.type)) return cut(element);
        value = 0.0;
      }
      row.push_back(value);
    }
    if (encoding_ == PlyEncoding::kAscii && word_ != words_.size()) {
      return file_.error(ErrorCode::kMalformedText, "more numbers than the header declares",
                         at_line(lines_.number()));
    }
    return {};
  }

  // Of the element, as much as the file can hold: no row takes less than its fixed part.
  [[nodiscard]] bool can_hold(const PlyElement& element) const {
    std::uint64_t least = 0;
    for (const PlyProperty& property : element.properties) {
      least += encoding_ == PlyEncoding::kAscii ? 2
               : property.is_list               ? property.count_type.size
                                                : property.type.size;
    }
    // The last line may lack its end.
    const std::uint64_t left = file_.bytes.size() - offset_ + 1;
    return least > 0 && element.count <= left / least + 1;
  }

  [[nodiscard]] Error cut(const PlyElement& element) const {
    const std::string place =
        encoding_ == PlyEncoding::kAscii ? at_line(lines_.number()) : at_byte(file_.bytes.size());
    return file_.error(ErrorCode::kTruncatedScan,
                       concat("fewer or other numbers than the ", element.count,
                              " rows of element ", element.name, " need"),
                       place);
  }

  Result<void> finish() {
    if (encoding_ == PlyEncoding::kAscii) offset_ = lines_.offset();
    if (is_padding(file_.text().substr(offset_))) return {};
    return file_.error(ErrorCode::kMalformedHeader, "data after the last row of the header",
                       at_byte(offset_));
  }
  [[nodiscard]] bool may_be_cut() const {
    return encoding_ == PlyEncoding::kAscii && !lines_.last_has_end();
  }

 private:
  bool next_line() {
    std::string_view line;
    do {
      if (!lines_.next(line)) return false;
      split_words(line, words_);
    } while (words_.empty());
    word_ = 0;
    return true;
  }

  bool read(ElementType type, double& value) {
    if (encoding_ == PlyEncoding::kAscii) {
      const std::optional<double> number =
          word_ < words_.size() ? to_number<double>(words_[word_++]) : std::nullopt;
      if (number) value = *number;
      return number.has_value();
    }
    if (file_.bytes.size() - offset_ < type.size) return false;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(file_.bytes.data()) + offset_;
    value = encoding_ == PlyEncoding::kLittleEndian ? read_element(bytes, type)
                                                    : read_big_endian_element(bytes, type);
    offset_ += type.size;
    return true;
  }

  bool skip(double count, ElementType type) {
    const std::size_t left = encoding_ == PlyEncoding::kAscii
                                 ? words_.size() - word_
                                 : (file_.bytes.size() - offset_) / type.size;
    if (!(count >= 0.0) || count > static_cast<double>(left) || count != std::floor(count)) {
      return false;
    }
    const auto whole = static_cast<std::size_t>(count);
    if (encoding_ == PlyEncoding::kAscii) {
      word_ += whole;
    } else {
      offset_ += whole * type.size;
    }
    return true;
  }

  const FileBytes& file_;
  PlyEncoding encoding_;
  std::size_t offset_;
  LineReader lines_;
  std::vector<std::string_view> words_;
  std::size_t word_ = 0;
};

double value_at(const std::vector<double>& row, std::ptrdiff_t place) {
  return place < 0 ? 0.0 : row[static_cast<std::size_t>(place)];
}

}  // namespace

Result<PointCloudFile> parse_ply(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const PlyHeader header, parse_ply_header(file));
  SIGHTLINE_ASSIGN(const VertexLayout layout, vertex_layout(file, header));
  PlyBody body(file, header);
  PointCloudFile cloud;
  std::vector<double> row;
  std::vector<double> times;
  for (const PlyElement& element : header.elements) {
    if (element.count > 0 && !body.can_hold(element)) return body.cut(element);
    const bool is_vertex = element.name == "vertex";
    for (std::uint64_t i = 0; i < element.count; ++i) {
      SIGHTLINE_TRY(body.read_row(element, row));
      if (!is_vertex) continue;
      const auto& [x, y, z] = layout.position;
      const Eigen::Vector3d point_m(value_at(row, x), value_at(row, y), value_at(row, z));
      const auto intensity = static_cast<float>(value_at(row, layout.intensity));
      if (add_point(cloud, point_m, intensity) && layout.time >= 0) {
        times.push_back(value_at(row, layout.time));
      }
    }
  }
  SIGHTLINE_TRY(body.finish());
  cloud.may_be_cut = body.may_be_cut();
  layout.time_name.set_times(times, cloud);
  return cloud;
}

}  // namespace sightline
