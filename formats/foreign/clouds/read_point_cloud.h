#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/float_columns.h"
#include "formats/foreign/clouds/float_counts.h"
#include "formats/foreign/clouds/point_cloud_file.h"

namespace sightline {

// Whether files of this ending ("." and small letters) are read: those below, and .gz of them.
bool is_scan_ending(std::string_view extension);

// ".pcd, .ply, .las, .npy or .bin", for messages.
std::string scan_endings_text();

// Reads PCD (ascii, binary, binary_compressed; versions up to 0.7; any order of fields, any field
// types, extra fields), PLY (ascii, binary of both byte orders), LAS (1.0 to 1.4, point formats 0
// to 10), .npy (an array of numpy, one point a row), .bin (float32 without a header: KITTI's x y z
// intensity, nuScenes' fifth float, the ring, and others), and any of them in gzip. Coordinates
// keep the precision that the file has: doubles and the decimal digits of text stay double. A file
// is checked against its own header and size before any of it is believed, so a damaged one is
// refused and never crashes.
//
// What the floats of a .bin are, `columns` says; without it they speak for themselves where one
// count of floats a point fits (fitting_counts), and begin with x y z intensity.
//
// Errors, with the byte or line: file-not-found, cannot-open, cannot-read, git-lfs-pointer,
// unsupported-format (LAZ, E57, archives, meshes, recordings of many scans, coordinates in degrees
// or feet, a .bin in which nothing shows how many floats a point has, ...; says what to do),
// malformed-header, malformed-text, missing-field (no x, y or z), truncated-scan, empty-scan (no
// points at all), no-finite-points (every point was dropped).
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
