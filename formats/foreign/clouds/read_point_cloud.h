#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/float_columns.h"
#include "formats/foreign/clouds/point_cloud_file.h"

namespace sightline {

// Whether files of this ending ("." and small letters) are read: those below, and .gz of them.
bool is_scan_ending(std::string_view extension);

// ".pcd, .ply, .las, .npy or .bin", for messages.
std::string scan_endings_text();

// Reads PCD (up to 0.7), PLY, LAS (1.0 to 1.4), .npy (one point a row), .bin (float32 without a
// header, by `columns` or fitting_counts), and any of them in gzip, in the file's precision.
// Errors, with the byte or line: file-not-found, cannot-open, cannot-read, git-lfs-pointer,
// unsupported-format (says what to do; also degrees or feet), malformed-header, malformed-text,
// missing-field (no x, y or z), truncated-scan, empty-scan, no-finite-points (all were dropped).
Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path,
                                        const std::optional<FloatColumns>& columns = {});

// The same from bytes that were read already; `path` decides between formats without a signature
// and names the file in errors.
Result<PointCloudFile> parse_point_cloud(std::span<const std::byte> bytes,
                                         const std::filesystem::path& path,
                                         const std::optional<FloatColumns>& columns = {});

// Whether nothing in files of this name says what their numbers are: .bin, and .bin.gz.
bool is_without_header(const std::filesystem::path& path);

// What the floats of such a file say of their number, and with which numbers its size agrees.
struct FloatEvidence {
  FloatCounts fitting = kAnyCount;
  FloatCounts dividing = kAnyCount;
  bool refutes = false;  // the count that the caller believes in
};
// All of them for what is no such file after all. Errors: those of parse_point_cloud for gzip.
Result<FloatEvidence> float_evidence(std::span<const std::byte> bytes,
                                     const std::filesystem::path& path,
                                     const std::optional<FloatColumns>& believed);

// The cloud, or no-finite-points where every point of it was left out.
Result<PointCloudFile> with_returns(PointCloudFile cloud, const std::string& file,
                                    const std::string& place);

}  // namespace sightline
