#include "formats/reader/map_layout.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "formats/base/bytes.h"
#include "formats/record/codec.h"

namespace sightline {

// Behind the version and the size of the header.
SIGHTLINE_SOME_FIELDS(FileHeader, compatible_features, incompatible_features, file_size,
                      manifest_offset, manifest_size, manifest_checksum, directory_offset,
                      directory_size, directory_checksum, root_digest)

namespace {

constexpr std::string_view kEndMagic("\n\x1a\n\rMLS\x89", 8);  // the beginning in reverse

bool starts_with(std::span<const std::byte> bytes, std::string_view magic) {
  const std::size_t size = std::min(bytes.size(), magic.size());
  return std::memcmp(bytes.data(), magic.data(), size) == 0;
}

Error truncated(std::size_t found, const std::string& expected) {
  return {ErrorCode::kTruncatedFile, concat("found ", found, " bytes, expected ", expected), "",
          concat("byte ", found)};
}

Result<void> check_start(std::span<const std::byte> file) {
  if (!file.empty() && !starts_with(file, kMapBeginning)) {
    return Error{ErrorCode::kBadMagic,
                 "the file is not a compiled map, or was damaged by a transfer as text", "",
                 "byte 0"};
  }
  if (file.size() < kHeaderSize + kTrailerSize) {
    return truncated(file.size(), "at least " + std::to_string(kHeaderSize + kTrailerSize));
  }
  ByteReader reader(file.subspan(kHeaderSize - 8, 8));
  if (reader.get<std::uint64_t>() != block_checksum(file.first(kHeaderSize - 8))) {
    return Error{ErrorCode::kChecksumMismatch, "the header does not match its checksum", "",
                 "byte " + std::to_string(kHeaderSize - 8)};
  }
  return {};
}

Result<void> check_end(std::span<const std::byte> file, const FileHeader& header) {
  if (file.size() < header.file_size) {
    return truncated(file.size(), std::to_string(header.file_size));
  }
  if (file.size() > header.file_size) {
    return Error{ErrorCode::kOutOfBounds,
                 concat("found ", file.size(), " bytes, expected ", header.file_size), "",
                 concat("byte ", header.file_size)};
  }
  std::array<std::byte, kHeaderSize> start{};
  std::copy_n(file.begin(), kHeaderSize, start.begin());
  const std::array<std::byte, kTrailerSize> expected = encode_trailer(header, start);
  if (!std::equal(expected.begin(), expected.end(), file.end() - kTrailerSize)) {
    return Error{ErrorCode::kChecksumMismatch, "the trailer does not match the header", "",
                 "byte " + std::to_string(file.size() - kTrailerSize)};
  }
  return {};
}

}  // namespace

std::string to_string(FormatVersion version) {
  return std::to_string(version.major) + "." + std::to_string(version.minor);
}

FileHeader header_fields(std::span<const std::byte> file) {
  ByteReader reader(file.subspan(kMapBeginning.size(), kHeaderSize - kMapBeginning.size()));
  FileHeader header;
  reader.get(header.version.major);
  reader.get(header.version.minor);
  (void)reader.get<std::uint32_t>();
  decode(reader, header);
  return header;
}

std::uint64_t block_checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::array<std::byte, kHeaderSize> encode_header(const FileHeader& header) {
  ByteWriter writer;
  writer.append(kMapBeginning.data(), kMapBeginning.size());
  writer.put(header.version.major);
  writer.put(header.version.minor);
  writer.put<std::uint32_t>(kHeaderSize);
  encode(header, writer);
  writer.put(block_checksum(writer.bytes()));
  std::array<std::byte, kHeaderSize> bytes{};
  SIGHTLINE_CHECK(writer.bytes().size() == bytes.size());
  std::copy(writer.bytes().begin(), writer.bytes().end(), bytes.begin());
  return bytes;
}

std::array<std::byte, kTrailerSize> encode_trailer(
    const FileHeader& header, const std::array<std::byte, kHeaderSize>& encoded_header) {
  ByteWriter writer;
  writer.put(header.file_size);
  writer.append(encoded_header.data() + kHeaderSize - 8, 8);
  writer.put<std::uint64_t>(0);
  writer.append(kEndMagic.data(), kEndMagic.size());
  std::array<std::byte, kTrailerSize> bytes{};
  SIGHTLINE_CHECK(writer.bytes().size() == bytes.size());
  std::copy(writer.bytes().begin(), writer.bytes().end(), bytes.begin());
  return bytes;
}

Result<FileHeader> decode_header_alone(std::span<const std::byte> file) {
  SIGHTLINE_TRY(check_start(file));
  return header_fields(file);
}

Result<FileHeader> decode_header(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(const FileHeader header, decode_header_alone(file));
  SIGHTLINE_TRY(check_end(file, header));
  return header;
}

std::array<double, 3> export_origin_world_m(const std::array<double, 3>& origin_world_m) {
  std::array<double, 3> taken_m{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double origin_m = origin_world_m[axis];
    if (std::abs(origin_m) < kExportSquare_m) continue;
    taken_m[axis] = std::floor(origin_m / kExportSquare_m) * kExportSquare_m;
  }
  return taken_m;
}

NdtLayout::NdtLayout(std::uint64_t rows) {
  for (std::uint64_t& begin : column) {
    begin = size;
    size = aligned(size + rows * 4);
  }
}

RangeLayout::RangeLayout(std::uint64_t rows, const AnswerShape& shape) {
  const auto& [ranges, limits, looks, is_small] = shape;
  const auto place = [&](std::uint64_t& begin, std::uint64_t bytes_per_row) {
    begin = size;
    size = aligned(size + rows * bytes_per_row);
  };
  place(site, 4);
  place(run, 4);
  place(s, 8);
  place(p_x, 8);
  place(p_y, 8);
  place(p_z, 8);
  place(range_index, limits);
  place(range_flags, limits);
  place(mean_error, 8 * ranges);
  place(probability, 8 * ranges * limits);
  place(site_flags, 1);
  place(extrapolated, ranges);
  place(pose, 8 * 12);
  place(look_index, looks > 0 ? limits : 0);
  place(look_flags, looks > 0 ? limits : 0);
  place(look_mean_error, 8 * looks);
  place(look_probability, 8 * looks * limits);
  place(look_extrapolated, looks);
  place(range_reason, limits);
  place(look_reason, looks > 0 ? limits : 0);
}

}  // namespace sightline
