#pragma once

#include <vector>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

// The parsers behind read_point_cloud(); not for other folders.

namespace sightline {

// Each refuses what contradicts itself; none drops the check for points that were all left out.
Result<PointCloudFile> parse_pcd(const FileBytes& file);
Result<PointCloudFile> parse_ply(const FileBytes& file);
Result<PointCloudFile> parse_las(const FileBytes& file);

inline constexpr std::string_view kNpySignature("\x93NUMPY", 6);

// An array of numpy, one point a row: numbers in 3 columns or more, x y z and perhaps an intensity
// as the fourth, or named fields x, y, z and perhaps intensity (or i, reflectivity). Numbers of 1
// to 8 bytes, of either byte order. Errors: malformed-header, missing-field, truncated-scan (fewer
// bytes than its shape says), unsupported-format (columns first, other dimensions, objects).
Result<PointCloudFile> parse_npy(const FileBytes& file);

bool is_gzip(std::string_view text);

// What all members of a gzip file hold, one after the other. Errors: truncated-scan (cut or
// damaged), malformed-header (bytes behind the last member), unsupported-format (more than 1 GiB).
Result<std::vector<std::byte>> unpack_gzip(const FileBytes& file);

}  // namespace sightline
