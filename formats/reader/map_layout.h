#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"

// The fixed parts of a compiled map (schemas/map_format.md), shared by its writer and its readers.

namespace sightline {

struct FormatVersion {
  std::uint16_t major = 0;
  std::uint16_t minor = 0;
  auto operator<=>(const FormatVersion&) const = default;
};
inline constexpr FormatVersion kFormatVersion{1, 0};

// A program reads every minor of its own major version: a later one adds only what may be skipped,
// an earlier one lacks only what may be absent.
constexpr bool can_read(FormatVersion program, FormatVersion file) {
  return file.major == program.major;
}

// "1.0"
std::string to_string(FormatVersion version);

inline constexpr std::size_t kHeaderSize = 128;
inline constexpr std::size_t kTrailerSize = 32;
// Every block starts on a cache line, and each of its columns too.
inline constexpr std::size_t kAlignment = 64;
// Fewer zeros than this lie between two blocks, so that no file is long for nothing.
inline constexpr std::uint64_t kWidestGap = 4096;
// Larger than any layer of a tile may be, small enough for a vehicle's memory.
inline constexpr std::uint64_t kLargestBlock = std::uint64_t{1} << 30;
// What a block may grow by when it is unpacked: ten times what layers of a real map reach, and too
// little for a small file to fill a machine's memory.
inline constexpr std::uint64_t kMostExpansion = 1024;

inline constexpr std::string_view kNdtLayer = "ndt";
inline constexpr std::string_view kRangeLayer = "range";
inline constexpr std::string_view kModelSection = "error-model";
// A section for each column of sites, its name behind this: f32[site_count], or the numbers of
// steps that the manifest lists, u8[site_count].
inline constexpr std::string_view kColumnSection = "column.";
inline constexpr std::uint32_t kColumnSectionVersion = 1;
inline constexpr std::uint32_t kSteppedColumnVersion = 2;
constexpr std::uint32_t column_version(bool has_steps) {
  return has_steps ? kSteppedColumnVersion : kColumnSectionVersion;
}
inline constexpr std::size_t kMostColumns = 256;
inline constexpr std::uint32_t kNdtLayerVersion = 1;
inline constexpr std::uint32_t kRangeLayerVersion = 2;
// Derived from the others: made anew by who writes a file, part of no digest.
inline constexpr std::string_view kContentsLayer = "contents";
inline constexpr std::string_view kLookUpSection = "look-up";
inline constexpr std::uint32_t kContentsLayerVersion = 1;
inline constexpr std::uint32_t kLookUpSectionVersion = 2;
constexpr bool is_derived(std::string_view block_name) {
  return block_name == kContentsLayer || block_name == kLookUpSection;
}

// The compatible feature "look-up", which every map has: that section is the last block and ends
// where the directory begins, so that a vehicle finds it without reading the directory.
inline constexpr std::uint8_t kLookUpFeatureBit = 0;

// A mean is stored relative to the centre of its cell, in this unit: 60 nm.
inline constexpr double kMeanUnit_m = 0x1.0p-24;

struct FileHeader {
  FormatVersion version = kFormatVersion;
  std::uint64_t compatible_features = 0;    // may be ignored by who does not know them
  std::uint64_t incompatible_features = 0;  // must be refused by who does not know them
  std::uint64_t file_size = 0;
  std::uint64_t manifest_offset = 0;
  std::uint64_t manifest_size = 0;
  std::uint64_t manifest_checksum = 0;  // XXH3
  std::uint64_t directory_offset = 0;
  std::uint64_t directory_size = 0;
  std::uint64_t directory_checksum = 0;  // XXH3
  std::array<std::uint8_t, 32> root_digest{};
};

constexpr bool has_look_up(const FileHeader& header) {
  return (header.compatible_features >> kLookUpFeatureBit & 1) != 0;
}

// Field by field, little-endian; the checksum at the end is filled in.
std::array<std::byte, kHeaderSize> encode_header(const FileHeader& header);
std::array<std::byte, kTrailerSize> encode_trailer(
    const FileHeader& header, const std::array<std::byte, kHeaderSize>& encoded_header);

// What the first kHeaderSize bytes of a file say, whether or not it is a map: for who mends files.
FileHeader header_fields(std::span<const std::byte> file);

// Magic, checksum and trailer are checked, and that the file has the size it says; version and
// features are not. Errors: truncated-file, bad-magic, checksum-mismatch, out-of-bounds.
Result<FileHeader> decode_header(std::span<const std::byte> file);

// The same of a file that may have lost its end: what the header says of the file is not checked.
// Errors: truncated-file, bad-magic, checksum-mismatch.
Result<FileHeader> decode_header_alone(std::span<const std::byte> file);

// XXH3, 64 bits, seed 0.
std::uint64_t block_checksum(std::span<const std::byte> bytes);

// Where a map's world lies that names none.
inline constexpr std::string_view kLocalWorld = "local";
// 1 to 64 printable characters without a blank.
constexpr bool is_world_name(std::string_view name) {
  for (const char c : name) {
    if (c <= ' ' || c > '~') return false;
  }
  return !name.empty() && name.size() <= 64;
}

// Exported clouds hold 32-bit floats, which are 4 mm apart at 50 km: the whole 100 km at or below
// the frame's origin are taken off x and y where that lies so far out. What is left of UTM are
// coordinates of an MGRS square.
inline constexpr double kExportSquare_m = 100'000.0;
std::array<double, 3> export_origin_world_m(const std::array<double, 3>& origin_world_m);

// Rounded up to the next multiple of kAlignment.
constexpr std::uint64_t aligned(std::uint64_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

// Where each column of a layer begins, and the layer's size. Every column starts at a multiple of
// kAlignment; the gap after it is zero. Rows are limited so that no size overflows.
struct NdtLayout {
  explicit NdtLayout(std::uint64_t rows);
  // 13 columns of 4 bytes: key x y z, point count, mean x y z, covariance xx xy xz yy yz zz.
  static constexpr std::size_t kColumns = 13;
  std::array<std::uint64_t, kColumns> column{};
  std::uint64_t size = 0;
};

// How many ranges, looks and limits a map's answers are for, by its manifest.
struct AnswerShape {
  std::uint64_t ranges = 0;
  std::uint64_t limits = 0;
  std::uint64_t looks = 0;  // that take a sample; may be none
  bool is_small = false;    // rounded, so that the section look-up keeps fewer bytes of each
};
// What numbers of a small map are multiples of.
inline constexpr double kSmallLength_m = 0x1.0p-10;
inline constexpr double kSmallShare = 0x1.0p-8;
inline constexpr double kSmallRotation = 0x1.0p-22;  // entries of rotation matrices
inline constexpr double kLongestSmallError_m = 65535 * kSmallLength_m;

struct RangeLayout {
  RangeLayout(std::uint64_t rows, const AnswerShape& shape);
  std::uint64_t site = 0;  // u32[rows], ascending
  std::uint64_t run = 0;   // u32[rows]
  std::uint64_t s = 0;     // f64[rows]
  std::uint64_t p_x = 0;   // f64[rows], map frame, m
  std::uint64_t p_y = 0;
  std::uint64_t p_z = 0;
  std::uint64_t range_index = 0;   // u8[rows][limits]
  std::uint64_t range_flags = 0;   // u8[rows][limits]
  std::uint64_t mean_error = 0;    // f64[rows][ranges]
  std::uint64_t probability = 0;   // f64[rows][ranges][limits]
  std::uint64_t site_flags = 0;    // u8[rows]
  std::uint64_t extrapolated = 0;  // u8[rows][ranges]
  std::uint64_t pose = 0;          // f64[rows][12]
  // As the five above, of the looks that take a sample; empty where there are none.
  std::uint64_t look_index = 0;         // u8[rows][limits]
  std::uint64_t look_flags = 0;         // u8[rows][limits]
  std::uint64_t look_mean_error = 0;    // f64[rows][looks]
  std::uint64_t look_probability = 0;   // f64[rows][looks][limits]
  std::uint64_t look_extrapolated = 0;  // u8[rows][looks]
  std::uint64_t range_reason = 0;       // u8[rows][limits]
  std::uint64_t look_reason = 0;        // u8[rows][limits], empty where there are no looks
  std::uint64_t size = 0;
};
inline constexpr std::uint64_t kMostRows = std::uint64_t{1} << 26;
inline constexpr std::uint64_t kMostRanges = 256;
inline constexpr std::uint64_t kPlanWeights = 8;  // of the test of a plan of looks
inline constexpr std::uint64_t kMostLimits = 64;

// Bits of the column site_flags.
inline constexpr std::uint8_t kSiteOutOfFold = 2;
inline constexpr std::uint8_t kSiteHasHistory = 4;

// The first bytes of every compiled map (schemas/map_format.md). A high bit, CR LF and a DOS end of
// file: a transfer as text changes one of them.
inline constexpr std::string_view kMapBeginning("\x89SLM\r\n\x1a\n", 8);

}  // namespace sightline
