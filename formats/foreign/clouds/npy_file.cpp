#include "formats/foreign/clouds/cloud_parsers.h"

#include <array>
#include <optional>
#include <vector>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/text_lines.h"

// numpy.lib.format: six bytes of signature, two of version, the length of a head, the head as a
// literal of Python, then the numbers.

namespace sightline {
namespace {

struct Field {
  std::string name;  // empty: one of equal columns
  ElementType type;
  bool is_big_endian = false;
};

struct Head {
  std::vector<Field> fields;  // one, or the named ones
  std::vector<std::uint64_t> shape;
  std::size_t data_begin = 0;
};

constexpr const char* kWanted = "expected rows of x y z (and intensity), or fields of these names";

Error unsupported(const FileBytes& file, const std::string& found) {
  return file.error(ErrorCode::kUnsupportedFormat,
                    concat("found ", found, ", ", kWanted,
                           "; write it with numpy.save(name, points.astype('float32'))"),
                    at_byte(0));
}

Error malformed(const FileBytes& file, std::string message) {
  return file.error(ErrorCode::kMalformedHeader, std::move(message), at_byte(0));
}

// "<f4" and its like.
std::optional<Field> field_of(std::string_view type) {
  Field field;
  if (type.size() < 3) return std::nullopt;
  field.is_big_endian = type[0] == '>';
  const std::optional<std::size_t> size = to_number<std::size_t>(type.substr(2));
  const bool is_size = size && (*size == 1 || *size == 2 || *size == 4 || *size == 8);
  if (!is_size || std::string_view("<>|=").find(type[0]) == std::string_view::npos) {
    return std::nullopt;
  }
  field.type.size = *size;
  if (std::string_view("iuf").find(type[1]) == std::string_view::npos) return std::nullopt;
  if (type[1] == 'f' && *size < 4) return std::nullopt;
  field.type.kind = type[1] == 'f'   ? ElementKind::kFloat
                    : type[1] == 'i' ? ElementKind::kSigned
                                     : ElementKind::kUnsigned;
  return field;
}

// What stands behind 'key': in the head, up to its end.
std::optional<std::string_view> value_of(std::string_view head, std::string_view key) {
  const std::string quoted = concat("'", key, "':");
  const std::size_t at = head.find(quoted);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view value = head.substr(at + quoted.size());
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  return value;
}

// Texts in quotes up to the bracket that closes the first one.
std::vector<std::string_view> quoted_texts(std::string_view list) {
  std::vector<std::string_view> texts;
  for (std::size_t at = 0; at < list.size() && list[at] != ']';) {
    if (list[at] != '\'') {
      ++at;
      continue;
    }
    const std::size_t end = list.find('\'', at + 1);
    if (end == std::string_view::npos) break;
    texts.push_back(list.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return texts;
}

Result<std::vector<Field>> fields_of(const FileBytes& file, std::string_view descr) {
  std::vector<Field> fields;
  const bool is_list = descr.starts_with('[');
  const std::vector<std::string_view> texts =
      quoted_texts(is_list ? descr : descr.substr(0, descr.find(',')));
  const std::size_t step = is_list ? 2 : 1;
  for (std::size_t i = 0; i + step <= texts.size(); i += step) {
    const std::optional<Field> field = field_of(texts[i + step - 1]);
    if (!field) return unsupported(file, "numbers of type " + in_quotes(texts[i + step - 1]));
    fields.push_back(*field);
    if (is_list) fields.back().name = texts[i];
  }
  if (fields.empty() || texts.size() % step != 0) {
    return malformed(file, "found no type of numbers in its header");
  }
  return fields;
}

Result<std::vector<std::uint64_t>> shape_of(const FileBytes& file, std::string_view text) {
  std::vector<std::string_view> words;
  const std::size_t end = text.find(')');
  if (!text.starts_with('(') || end == std::string_view::npos) {
    return malformed(file, "found no shape in its header");
  }
  split_words(text.substr(1, end - 1), words, ", ");
  std::vector<std::uint64_t> shape;
  for (const std::string_view word : words) {
    const std::optional<std::uint64_t> size = to_number<std::uint64_t>(word);
    if (!size || *size > (std::uint64_t{1} << 40)) {
      return malformed(file, "found a shape of " + in_quotes(word));
    }
    shape.push_back(*size);
  }
  return shape;
}

Result<Head> head_of(const FileBytes& file) {
  const std::string_view text = file.text();
  constexpr std::size_t kVersionEnd = 8;
  if (text.size() < kVersionEnd + 4) return malformed(file, "shorter than its header");
  const bool is_first = text[6] == 1;
  const std::size_t length = is_first ? read_at<std::uint16_t>(file.bytes, kVersionEnd)
                                      : read_at<std::uint32_t>(file.bytes, kVersionEnd);
  Head head;
  const std::size_t begin = is_first ? 10 : 12;
  if (length > text.size() - begin) return malformed(file, "shorter than its header");
  head.data_begin = begin + length;
  const std::string_view literal = text.substr(begin, length);
  const std::optional<std::string_view> descr = value_of(literal, "descr");
  const std::optional<std::string_view> shape = value_of(literal, "shape");
  const std::optional<std::string_view> order = value_of(literal, "fortran_order");
  if (!descr || !shape || !order) {
    return malformed(file, "its header lacks descr, fortran_order or shape");
  }
  if (order->starts_with("True")) return unsupported(file, "an array stored column by column");
  SIGHTLINE_ASSIGN(head.fields, fields_of(file, *descr));
  SIGHTLINE_ASSIGN(head.shape, shape_of(file, *shape));
  return head;
}

// Where in a row the coordinates and the intensity stand.
struct Layout {
  std::array<std::size_t, 4> offset{};
  std::array<Field, 4> field;
  bool has_intensity = false;
  std::size_t row_size = 0;
  std::uint64_t rows = 0;
};

Result<Layout> layout_of(const FileBytes& file, const Head& head) {
  Layout layout;
  const bool has_names = !head.fields.front().name.empty();
  const std::size_t dimensions = has_names ? 1 : 2;
  if (head.shape.size() != dimensions ||
      (!has_names && (head.shape[1] < 3 || head.shape[1] > 1024))) {
    return unsupported(file, "an array of another shape");
  }
  layout.rows = head.shape[0];
  if (!has_names) {
    const std::size_t size = head.fields.front().type.size;
    for (std::size_t i = 0; i < 4; ++i) {
      layout.offset[i] = i * size;
      layout.field[i] = head.fields.front();
    }
    layout.has_intensity = head.shape[1] > 3;
    layout.row_size = size * head.shape[1];
    return layout;
  }
  std::array<bool, 4> found{};
  for (const Field& field : head.fields) {
    for (std::size_t i = 0; i < 4; ++i) {
      const bool is_it =
          i < 3 ? field.name == std::string(1, static_cast<char>('x' + i))
                : field.name == "intensity" || field.name == "i" || field.name == "reflectivity";
      if (!is_it || found[i]) continue;
      found[i] = true;
      layout.offset[i] = layout.row_size;
      layout.field[i] = field;
    }
    layout.row_size += field.type.size;
  }
  layout.has_intensity = found[3];
  if (found[0] && found[1] && found[2]) return layout;
  return file.error(ErrorCode::kMissingField, "found no fields x, y and z", at_byte(0));
}

}  // namespace

Result<PointCloudFile> parse_npy(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const Head head, head_of(file));
  SIGHTLINE_ASSIGN(const Layout layout, layout_of(file, head));
  const std::size_t there = file.bytes.size() - head.data_begin;
  if (layout.rows > there / layout.row_size) {
    return file.error(ErrorCode::kTruncatedScan,
                      concat("found ", there, " bytes of numbers, expected ", layout.rows,
                             " rows of ", layout.row_size),
                      at_byte(head.data_begin));
  }
  const auto* data = reinterpret_cast<const std::uint8_t*>(file.bytes.data()) + head.data_begin;
  PointCloudFile cloud;
  for (std::uint64_t row = 0; row < layout.rows; ++row) {
    const std::uint8_t* begin = data + row * layout.row_size;
    const auto number = [&](std::size_t i) {
      const Field& field = layout.field[i];
      return field.is_big_endian ? read_big_endian_element(begin + layout.offset[i], field.type)
                                 : read_element(begin + layout.offset[i], field.type);
    };
    add_point(cloud, {number(0), number(1), number(2)},
              layout.has_intensity ? static_cast<float>(number(3)) : 0.0F);
  }
  return cloud;
}

}  // namespace sightline
