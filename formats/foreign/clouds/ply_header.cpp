#include "formats/foreign/clouds/ply_header.h"

#include <optional>
#include <string_view>

#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

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
  if (name == "ascii") {
    header.encoding = PlyEncoding::kAscii;
  } else if (name == "binary_little_endian") {
    header.encoding = PlyEncoding::kLittleEndian;
  } else if (name == "binary_big_endian") {
    header.encoding = PlyEncoding::kBigEndian;
  } else {
    return malformed(file, line,
                     "expected format ascii, binary_little_endian or "
                     "binary_big_endian, version 1.0");
  }
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

}  // namespace

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

}  // namespace sightline
