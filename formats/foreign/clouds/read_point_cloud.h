#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/result.h"
#include "formats/foreign/clouds/point_cloud_file.h"

namespace sightline {

// Whether files of this ending ("." and small letters) are read: those below, and .gz of them.
bool is_scan_ending(std::string_view extension);

// ".pcd, .ply, .las or .bin", for messages.
std::string scan_endings_text();

// Reads PCD (ascii, binary, binary_compressed; versions up to 0.7; any order of fields, any field
// types, extra fields), PLY (ascii, binary of both byte orders), LAS (1.0 to 1.4, point formats 0
// to 10), .bin of KITTI (x y z intensity as float32, no header) and of nuScenes (a fifth float, the
// ring), and any of them in gzip. Coordinates keep the precision that the file has: doubles and the
// decimal digits of text stay double. A file is checked against its own header and size before any
// of it is believed, so a damaged one is refused and never crashes.
//
// Errors, with the byte or line: file-not-found, cannot-open, cannot-read, git-lfs-pointer,
// unsupported-format (LAZ, E57, archives, meshes, recordings of many scans, ...; says how to
// convert), malformed-header, malformed-text, missing-field (no x, y or z), truncated-scan,
// empty-scan (no points at all), no-finite-points (every point was dropped).
Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path);

// The same from bytes that were read already; `path` decides between formats without a signature
// and names the file in errors.
Result<PointCloudFile> parse_point_cloud(std::span<const std::byte> bytes,
                                         const std::filesystem::path& path);

// The cloud, or no-finite-points where every point of it was left out.
Result<PointCloudFile> with_returns(PointCloudFile cloud, const std::string& file,
                                    const std::string& place);

}  // namespace sightline
