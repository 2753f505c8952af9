#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/clouds/pcd_unpack.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

struct PcdField {
  std::string name;         // "_" is padding
  char type = 'F';          // F, I or U
  std::size_t size = 4;     // bytes of one element
  std::size_t count = 1;    // elements
  std::size_t offset = 0;   // bytes from the start of a point
  std::size_t element = 0;  // elements before it, as words of a text line

  [[nodiscard]] std::size_t bytes() const { return size * count; }
};

enum class PcdEncoding { kAscii, kBinary, kBinaryCompressed };

// The header of a PCD file (versions .5 to .7), consistent in itself.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint32_t point_count = 0;
  std::size_t point_size = 0;     // bytes
  std::size_t element_count = 0;  // words a text line
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t data_offset = 0;
  std::size_t header_lines = 0;

  // nullptr where there is none.
  [[nodiscard]] const PcdField* field(std::string_view name) const;
  [[nodiscard]] const PcdField* intensity() const;
  [[nodiscard]] const PcdField* time() const;  // of each point
  TimeName time_name;
  std::optional<Eigen::Vector3d> viewpoint_m;  // nothing: the origin, unturned
};

// The words behind a keyword, and where they stood.
struct Entry {
  std::vector<std::string_view> values;
  std::size_t line = 0;
};
using Entries = std::map<std::string_view, Entry>;

bool is_keyword(std::string_view word) {
  constexpr std::string_view kKnown[] = {"VERSION",   "FIELDS", "COLUMNS", "SIZE",
                                         "TYPE",      "COUNT",  "WIDTH",   "HEIGHT",
                                         "VIEWPOINT", "POINTS", "DATA"};
  return std::ranges::find(kKnown, word) != std::end(kKnown);
}

Error malformed(const FileBytes& file, std::size_t line, std::string message) {
  return file.error(ErrorCode::kMalformedHeader, std::move(message), at_line(line));
}

Result<Entries> read_entries(const FileBytes& file, PcdHeader& header) {
  Entries entries;
  LineReader reader(file.text());
  std::string_view line;
  std::vector<std::string_view> words;
  while (reader.next(line)) {
    split_words(line, words);
    if (words.empty() || words.front().starts_with('#')) continue;
    std::string_view keyword = words.front();
    if (!reader.last_has_end() && keyword != "DATA") break;
    if (!is_keyword(keyword)) {
      return malformed(
          file, reader.number(),
          concat("found ", in_quotes(keyword), ", expected a keyword of a PCD header"));
    }
    if (keyword == "COLUMNS") keyword = "FIELDS";
    Entry entry{{words.begin() + 1, words.end()}, reader.number()};
    if (!entries.emplace(keyword, entry).second) {
      return malformed(file, reader.number(), "a second " + std::string(keyword));
    }
    if (keyword == "DATA") {
      if (!reader.last_has_end()) break;
      header.data_offset = reader.offset();
      header.header_lines = reader.number();
      return entries;
    }
  }
  return file.error(ErrorCode::kTruncatedScan, "the file ends before the DATA line of its header",
                    at_byte(file.bytes.size()));
}

Result<void> check_version(const FileBytes& file, const Entries& entries) {
  const auto entry = entries.find("VERSION");
  if (entry == entries.end()) return {};
  const std::vector<std::string_view>& values = entry->second.values;
  if (values.size() == 1) {
    for (const std::string_view known : {".5", ".6", ".7", "0.5", "0.6", "0.7"}) {
      if (values.front() == known) return {};
    }
  }
  return file.error(ErrorCode::kUnsupportedFormat,
                    concat("PCD version ", (values.empty() ? "''" : in_quotes(values.front())),
                           " is not known, expected 0.7 or earlier"),
                    at_line(entry->second.line));
}

// Whole numbers of one keyword, one for each field.
Result<std::vector<std::size_t>> numbers_per_field(const FileBytes& file, const Entry& entry,
                                                   std::size_t field_count, std::size_t most) {
  if (entry.values.size() != field_count) {
    return malformed(file, entry.line,
                     concat("found ", entry.values.size(), " values for ", field_count, " fields"));
  }
  std::vector<std::size_t> numbers;
  for (const std::string_view word : entry.values) {
    const std::optional<std::size_t> number = to_number<std::size_t>(word);
    if (!number || *number < 1 || *number > most) {
      return malformed(
          file, entry.line,
          concat("found ", in_quotes(word), ", expected a whole number from 1 to ", most));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Result<void> read_types(const FileBytes& file, const Entry& entry, PcdHeader& header) {
  if (entry.values.size() != header.fields.size()) {
    return malformed(
        file, entry.line,
        concat("found ", entry.values.size(), " types for ", header.fields.size(), " fields"));
  }
  for (std::size_t i = 0; i < entry.values.size(); ++i) {
    PcdField& field = header.fields[i];
    field.type = entry.values[i].front();
    const bool is_float = field.type == 'F' && (field.size == 4 || field.size == 8);
    const bool is_whole =
        (field.type == 'I' || field.type == 'U') &&
        (field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8);
    // Padding has no type worth the name: it is skipped.
    if (entry.values[i].size() != 1 || (!is_float && !is_whole && field.name != "_")) {
      return malformed(
          file, entry.line,
          concat("found type ", in_quotes(entry.values[i]), " of ", field.size, " bytes for field ",
                 in_quotes(field.name), ", expected F of 4 or 8, or I or U of 1, 2, 4 or 8"));
    }
  }
  return {};
}

Result<void> read_fields(const FileBytes& file, const Entries& entries, PcdHeader& header) {
  constexpr std::size_t kMostElements = 1U << 20U;  // the largest descriptors have some thousand
  for (const std::string_view needed : {"FIELDS", "SIZE", "TYPE"}) {
    if (!entries.contains(needed)) {
      return malformed(file, header.header_lines, "the header has no " + std::string(needed));
    }
  }
  for (const std::string_view name : entries.at("FIELDS").values) {
    header.fields.emplace_back().name = name;
  }
  const std::size_t count = header.fields.size();
  SIGHTLINE_ASSIGN(const std::vector<std::size_t> sizes,
                   numbers_per_field(file, entries.at("SIZE"), count, 8));
  for (std::size_t i = 0; i < count; ++i) header.fields[i].size = sizes[i];
  SIGHTLINE_TRY(read_types(file, entries.at("TYPE"), header));
  if (const auto entry = entries.find("COUNT"); entry != entries.end()) {
    const auto counts = numbers_per_field(file, entry->second, count, kMostElements);
    if (!counts) return counts.error();
    for (std::size_t i = 0; i < count; ++i) header.fields[i].count = (*counts)[i];
  }
  for (PcdField& field : header.fields) {
    field.offset = header.point_size;
    field.element = header.element_count;
    header.point_size += field.bytes();
    header.element_count += field.count;
  }
  return {};
}

Result<std::uint64_t> read_count(const FileBytes& file, const Entries& entries,
                                 std::string_view keyword, std::uint64_t otherwise) {
  const auto entry = entries.find(keyword);
  if (entry == entries.end()) return otherwise;
  const std::optional<std::uint64_t> number =
      entry->second.values.size() == 1 ? to_number<std::uint64_t>(entry->second.values.front())
                                       : std::nullopt;
  // PCL counts points in an int.
  if (!number || *number > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) {
    return malformed(file, entry->second.line,
                     std::string(keyword) + " is not a whole number up to 2147483647");
  }
  return *number;
}

Result<void> read_point_count(const FileBytes& file, const Entries& entries, PcdHeader& header) {
  SIGHTLINE_ASSIGN(const std::uint64_t height, read_count(file, entries, "HEIGHT", 1));
  SIGHTLINE_ASSIGN(const std::uint64_t given, read_count(file, entries, "POINTS", 0));
  SIGHTLINE_ASSIGN(const std::uint64_t width, read_count(file, entries, "WIDTH", given));
  const bool has_points = entries.contains("POINTS");
  if (!has_points && !entries.contains("WIDTH")) {
    return malformed(file, header.header_lines, "the header has neither POINTS nor WIDTH");
  }
  const std::uint64_t product = width * height;
  if ((has_points && product != given) ||
      product > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) {
    return malformed(file,
                     entries.contains("POINTS") ? entries.at("POINTS").line : header.header_lines,
                     concat("WIDTH ", width, " x HEIGHT ", height, " is not POINTS ", given));
  }
  if (product == 0) {
    return file.error(ErrorCode::kEmptyScan, "the header has a count of 0 points",
                      at_line(header.header_lines));
  }
  header.point_count = static_cast<std::uint32_t>(product);
  return {};
}

Result<void> read_encoding(const FileBytes& file, const Entry& entry, PcdHeader& header) {
  const std::string_view word = entry.values.size() == 1 ? entry.values.front() : "";
  if (word == "ascii") {
    header.encoding = PcdEncoding::kAscii;
  } else if (word == "binary") {
    header.encoding = PcdEncoding::kBinary;
  } else if (word == "binary_compressed") {
    header.encoding = PcdEncoding::kBinaryCompressed;
  } else {
    return malformed(
        file, entry.line,
        concat("found DATA ", in_quotes(word), ", expected ascii, binary or binary_compressed"));
  }
  return {};
}

Result<void> check_position_fields(const FileBytes& file, const PcdHeader& header) {
  for (const std::string_view name : {"x", "y", "z"}) {
    const PcdField* field = header.field(name);
    if (std::ranges::count(header.fields, name, &PcdField::name) > 1) {
      return malformed(file, header.header_lines, "a second field " + std::string(name));
    }
    if (field != nullptr && field->count == 1) continue;
    std::string found;
    for (const PcdField& other : header.fields) found += (found.empty() ? "" : " ") + other.name;
    return file.error(ErrorCode::kMissingField,
                      concat("found fields ", in_quotes(found), ", expected one named ", name),
                      at_line(header.header_lines));
  }
  return {};
}

template <class Test>
const PcdField* first_field(const PcdHeader& header, Test is_it) {
  const auto found = std::ranges::find_if(header.fields, is_it);
  return found == header.fields.end() ? nullptr : &*found;
}

const PcdField* PcdHeader::field(std::string_view name) const {
  return first_field(*this, [&](const PcdField& field) { return field.name == name; });
}

const PcdField* PcdHeader::intensity() const {
  return first_field(*this, [](const PcdField& field) {
    return is_intensity_name(field.name) && field.count == 1;
  });
}

const PcdField* PcdHeader::time() const {
  TimeName names;
  const PcdField* chosen = nullptr;
  for (const PcdField& field : fields) {
    if (field.count == 1 && names.take(field.name)) chosen = &field;
  }
  return chosen;
}

// x y z and a quaternion w x y z. What is no such thing is ignored: the points do not need it.
std::optional<Eigen::Vector3d> viewpoint_of(const Entries& entries) {
  const auto entry = entries.find("VIEWPOINT");
  if (entry == entries.end()) return std::nullopt;
  std::vector<double> numbers;
  for (const std::string_view word : entry->second.values) {
    numbers.push_back(finite_number(word).value_or(0.0));
  }
  const bool is_origin =
      std::ranges::all_of(numbers, [](double n) { return n == 0.0 || n == 1.0; });
  if (numbers.size() != 7 || is_origin) return std::nullopt;
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

// Errors: truncated-scan (ends before DATA), malformed-header, missing-field, unsupported-format (a
// later version), empty-scan (says it has no points).
Result<PcdHeader> parse_pcd_header(const FileBytes& file) {
  PcdHeader header;
  SIGHTLINE_ASSIGN(const Entries entries, read_entries(file, header));
  SIGHTLINE_TRY(check_version(file, entries));
  SIGHTLINE_TRY(read_fields(file, entries, header));
  SIGHTLINE_TRY(check_position_fields(file, header));
  SIGHTLINE_TRY(read_point_count(file, entries, header));
  SIGHTLINE_TRY(read_encoding(file, entries.at("DATA"), header));
  for (const PcdField& field : header.fields) {
    if (field.count == 1) header.time_name.take(field.name);
  }
  header.viewpoint_m = viewpoint_of(entries);
  return header;
}

ElementType element_type(const PcdField& field) {
  const ElementKind kind = field.type == 'F'   ? ElementKind::kFloat
                           : field.type == 'I' ? ElementKind::kSigned
                                               : ElementKind::kUnsigned;
  return {kind, field.size};
}

// Every word must be a number, also those that are not used: a cut or shifted line shows there.
Result<void> read_words(const FileBytes& file, std::size_t line_number, std::size_t expected,
                        const std::vector<std::string_view>& words, std::vector<double>& numbers) {
  if (words.size() != expected) {
    return file.error(ErrorCode::kTruncatedScan,
                      concat("found ", words.size(), " numbers, expected ", expected),
                      at_line(line_number));
  }
  numbers.clear();
  for (const std::string_view word : words) {
    const std::optional<double> number = to_number<double>(word);
    if (!number) {
      return file.error(ErrorCode::kMalformedText,
                        concat("found ", in_quotes(word), ", expected a number"),
                        at_line(line_number));
    }
    numbers.push_back(*number);
  }
  return {};
}

// Read here and not by PCL, which rounds to the field's type: text in UTM coordinates says
// millimetres that a float32 loses.
Result<PointCloudFile> parse_ascii(const FileBytes& file, const PcdHeader& header) {
  const std::array<std::size_t, 3> position = {
      header.field("x")->element, header.field("y")->element, header.field("z")->element};
  const PcdField* intensity = header.intensity();
  const PcdField* time = header.time();
  LineReader reader(file.text(), header.data_offset, header.header_lines);
  PointCloudFile cloud;
  std::string_view line;
  std::vector<std::string_view> words;
  std::vector<double> numbers;
  std::vector<double> times;
  std::uint64_t count = 0;
  while (reader.next(line)) {
    split_words(line, words);
    if (words.empty() || is_padding(line)) continue;
    if (count == header.point_count) {
      return file.error(ErrorCode::kMalformedHeader,
                        concat("more points than the ", count, " of the header"),
                        at_line(reader.number()));
    }
    SIGHTLINE_TRY(read_words(file, reader.number(), header.element_count, words, numbers));
    const bool is_return =
        add_point(cloud, {numbers[position[0]], numbers[position[1]], numbers[position[2]]},
                  intensity ? static_cast<float>(numbers[intensity->element]) : 0.0F);
    if (is_return && time) times.push_back(numbers[time->element]);
    ++count;
    cloud.may_be_cut = !reader.last_has_end();
  }
  if (count < header.point_count) {
    return file.error(
        ErrorCode::kTruncatedScan,
        concat("found ", count, " points, expected the header's ", header.point_count),
        at_line(reader.number()));
  }
  header.time_name.set_times(times, cloud);
  return cloud;
}

// Where the fields lie in a body of whole points, or of whole columns one after the other.
PointColumns columns_of(const std::uint8_t* body, const PcdHeader& header, bool is_packed_columns) {
  const auto column = [&](const PcdField& field) -> FieldColumn {
    if (is_packed_columns) {
      return {body + field.offset * header.point_count, field.bytes(), element_type(field)};
    }
    return {body + field.offset, header.point_size, element_type(field)};
  };
  PointColumns columns;
  columns.count = header.point_count;
  columns.position = {column(*header.field("x")), column(*header.field("y")),
                      column(*header.field("z"))};
  if (const PcdField* intensity = header.intensity()) columns.intensity = column(*intensity);
  if (const PcdField* time = header.time()) columns.time = column(*time);
  columns.time_name = header.time_name;
  return columns;
}

Result<void> check_rest(const FileBytes& file, std::size_t end) {
  if (is_padding(file.text().substr(end))) return {};
  return file.error(
      ErrorCode::kMalformedHeader,
      concat("found ", file.bytes.size() - end, " bytes after the last point of the header"),
      at_byte(end));
}

Error too_short(const FileBytes& file, std::size_t expected) {
  return file.error(ErrorCode::kTruncatedScan,
                    concat("found ", file.bytes.size(), " bytes, the header requires ", expected),
                    at_byte(file.bytes.size()));
}

// Padding is left out of the compressed columns by PCL and kept by others; the size decides.
PcdHeader without_padding(const PcdHeader& header) {
  PcdHeader packed = header;
  std::erase_if(packed.fields, [](const PcdField& field) { return field.name == "_"; });
  packed.point_size = 0;
  for (PcdField& field : packed.fields) {
    field.offset = packed.point_size;
    packed.point_size += field.bytes();
  }
  return packed;
}

const std::uint8_t* body_of(const FileBytes& file, const PcdHeader& header) {
  return reinterpret_cast<const std::uint8_t*>(file.bytes.data()) + header.data_offset;
}

struct CompressedBody {
  PcdHeader header;  // as the columns lie
  std::span<const std::uint8_t> packed;
  std::size_t size = 0;  // unpacked, bytes
};

// Body: u32 compressed size, u32 unpacked size, LZF stream of whole columns.
Result<CompressedBody> check_compressed(const FileBytes& file, const PcdHeader& header) {
  constexpr std::size_t kSizes = 8;
  // Three bytes of LZF say at most 264.
  constexpr std::uint64_t kMostExpansion = 88;
  if (file.bytes.size() - header.data_offset < kSizes) {
    return too_short(file, header.data_offset + kSizes);
  }
  const auto packed_size = read_at<std::uint32_t>(file.bytes, header.data_offset);
  const auto size = read_at<std::uint32_t>(file.bytes, header.data_offset + 4);
  const std::size_t end = header.data_offset + kSizes + packed_size;
  if (file.bytes.size() < end) return too_short(file, end);
  SIGHTLINE_TRY(check_rest(file, end));
  CompressedBody body{header, {body_of(file, header) + kSizes, packed_size}, size};
  if (size != static_cast<std::uint64_t>(header.point_count) * header.point_size) {
    body.header = without_padding(header);
  }
  const std::uint64_t needed =
      static_cast<std::uint64_t>(header.point_count) * body.header.point_size;
  if (size != needed || needed > packed_size * kMostExpansion) {
    return file.error(ErrorCode::kMalformedHeader,
                      concat("found ", packed_size, " bytes that unpack to ", size,
                             ", the header requires ", needed),
                      at_byte(header.data_offset));
  }
  return body;
}

Result<PointCloudFile> parse_binary(const FileBytes& file, const PcdHeader& header) {
  const std::uint64_t size = static_cast<std::uint64_t>(header.point_count) * header.point_size;
  if (file.bytes.size() - header.data_offset < size) {
    return too_short(file, header.data_offset + size);
  }
  SIGHTLINE_TRY(check_rest(file, header.data_offset + size));
  return read_points(columns_of(body_of(file, header), header, false));
}

Result<PointCloudFile> parse_compressed(const FileBytes& file, const PcdHeader& header) {
  SIGHTLINE_ASSIGN(const CompressedBody body, check_compressed(file, header));
  // Not filled with zeros first.
  const std::unique_ptr<std::uint8_t[]> unpacked(new (std::nothrow) std::uint8_t[body.size]);
  if (!unpacked)
    return file.error(ErrorCode::kOutOfMemory, "the points do not fit into memory", "");
  if (!unpack_lzf(body.packed, {unpacked.get(), body.size})) {
    return file.error(ErrorCode::kTruncatedScan, "the compressed points do not unpack",
                      at_byte(header.data_offset));
  }
  return read_points(columns_of(unpacked.get(), body.header, true));
}

Result<PointCloudFile> parse_points(const FileBytes& file, const PcdHeader& header) {
  switch (header.encoding) {
    case PcdEncoding::kAscii:
      return parse_ascii(file, header);
    case PcdEncoding::kBinary:
      return parse_binary(file, header);
    case PcdEncoding::kBinaryCompressed:
      return parse_compressed(file, header);
  }
  return file.error(ErrorCode::kMalformedHeader, "no encoding", "");
}

}  // namespace

Result<PointCloudFile> parse_pcd(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const PcdHeader header, parse_pcd_header(file));
  Result<PointCloudFile> cloud = parse_points(file, header);
  if (cloud) cloud->viewpoint_m = header.viewpoint_m;
  return cloud;
}

}  // namespace sightline
