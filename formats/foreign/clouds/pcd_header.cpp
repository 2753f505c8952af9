#include "formats/foreign/clouds/pcd_header.h"

#include <algorithm>
#include <limits>
#include <map>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

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
      return malformed(file, reader.number(),
                       "found " + in_quotes(keyword) + ", expected a keyword of a PCD header");
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
                    "PCD version " + (values.empty() ? "''" : in_quotes(values.front())) +
                        " is not known, expected 0.7 or earlier",
                    at_line(entry->second.line));
}

// Whole numbers of one keyword, one for each field.
Result<std::vector<std::size_t>> numbers_per_field(const FileBytes& file, const Entry& entry,
                                                   std::size_t field_count, std::size_t most) {
  if (entry.values.size() != field_count) {
    return malformed(file, entry.line,
                     "found " + std::to_string(entry.values.size()) + " values for " +
                         std::to_string(field_count) + " fields");
  }
  std::vector<std::size_t> numbers;
  for (const std::string_view word : entry.values) {
    const std::optional<std::size_t> number = to_number<std::size_t>(word);
    if (!number || *number < 1 || *number > most) {
      return malformed(file, entry.line,
                       "found " + in_quotes(word) + ", expected a whole number from 1 to " +
                           std::to_string(most));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

Result<void> read_types(const FileBytes& file, const Entry& entry, PcdHeader& header) {
  if (entry.values.size() != header.fields.size()) {
    return malformed(file, entry.line,
                     "found " + std::to_string(entry.values.size()) + " types for " +
                         std::to_string(header.fields.size()) + " fields");
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
      return malformed(file, entry.line,
                       "found type " + in_quotes(entry.values[i]) + " of " +
                           std::to_string(field.size) + " bytes for field " +
                           in_quotes(field.name) +
                           ", expected F of 4 or 8, or I or U of 1, 2, 4 or 8");
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
                     std::string(keyword) + " is no whole number up to 2147483647");
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
                     "WIDTH " + std::to_string(width) + " x HEIGHT " + std::to_string(height) +
                         " is not POINTS " + std::to_string(given));
  }
  if (product == 0) {
    return file.error(ErrorCode::kEmptyScan, "the header says that there are no points",
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
        "found DATA " + in_quotes(word) + ", expected ascii, binary or binary_compressed");
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
    return file.error(
        ErrorCode::kMissingField,
        "found fields " + in_quotes(found) + ", expected one named " + std::string(name),
        at_line(header.header_lines));
  }
  return {};
}

template <class Test>
const PcdField* first_field(const PcdHeader& header, Test is_it) {
  const auto found = std::ranges::find_if(header.fields, is_it);
  return found == header.fields.end() ? nullptr : &*found;
}

}  // namespace

const PcdField* PcdHeader::field(std::string_view name) const {
  return first_field(*this, [&](const PcdField& field) { return field.name == name; });
}

const PcdField* PcdHeader::intensity() const {
  return first_field(*this, [](const PcdField& field) {
    return is_intensity_name(field.name) && field.count == 1;
  });
}

const PcdField* PcdHeader::time() const {
  return first_field(
      *this, [](const PcdField& field) { return is_time_name(field.name) && field.count == 1; });
}

Result<PcdHeader> parse_pcd_header(const FileBytes& file) {
  PcdHeader header;
  SIGHTLINE_ASSIGN(const Entries entries, read_entries(file, header));
  SIGHTLINE_TRY(check_version(file, entries));
  SIGHTLINE_TRY(read_fields(file, entries, header));
  SIGHTLINE_TRY(check_position_fields(file, header));
  SIGHTLINE_TRY(read_point_count(file, entries, header));
  SIGHTLINE_TRY(read_encoding(file, entries.at("DATA"), header));
  return header;
}

}  // namespace sightline
