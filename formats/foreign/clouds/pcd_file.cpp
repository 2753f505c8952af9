#include <array>
#include <memory>
#include <new>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/clouds/pcd_header.h"
#include "formats/foreign/clouds/pcd_unpack.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

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
    return file.error(
        ErrorCode::kTruncatedScan,
        "found " + std::to_string(words.size()) + " numbers, expected " + std::to_string(expected),
        at_line(line_number));
  }
  numbers.clear();
  for (const std::string_view word : words) {
    const std::optional<double> number = to_number<double>(word);
    if (!number) {
      return file.error(ErrorCode::kMalformedText,
                        "found " + in_quotes(word) + ", expected a number", at_line(line_number));
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
                        "more points than the " + std::to_string(count) + " of the header",
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
    return file.error(ErrorCode::kTruncatedScan,
                      "found " + std::to_string(count) + " points, expected the header's " +
                          std::to_string(header.point_count),
                      at_line(reader.number()));
  }
  if (time) set_point_times(times, cloud);
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
  return columns;
}

Result<void> check_rest(const FileBytes& file, std::size_t end) {
  if (is_padding(file.text().substr(end))) return {};
  return file.error(ErrorCode::kMalformedHeader,
                    "found " + std::to_string(file.bytes.size() - end) +
                        " bytes behind the last point that the header speaks of",
                    at_byte(end));
}

Error too_short(const FileBytes& file, std::size_t expected) {
  return file.error(ErrorCode::kTruncatedScan,
                    "found " + std::to_string(file.bytes.size()) + " bytes, the header asks for " +
                        std::to_string(expected),
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
                      "found " + std::to_string(packed_size) + " bytes that unpack to " +
                          std::to_string(size) + ", the header asks for " + std::to_string(needed),
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

}  // namespace

Result<PointCloudFile> parse_pcd(const FileBytes& file) {
  SIGHTLINE_ASSIGN(const PcdHeader header, parse_pcd_header(file));
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

}  // namespace sightline
