#pragma once

#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {

inline constexpr std::string_view kNpySignature("\x93NUMPY", 6);

// An array of numpy, one point a row: numbers in 3 columns or more, x y z and perhaps an intensity
// as the fourth, or named fields x, y, z and perhaps intensity (or i, reflectivity). Numbers of 1
// to 8 bytes, of either byte order. Errors: malformed-header, missing-field, truncated-scan (fewer
// bytes than its shape says), unsupported-format (columns first, other dimensions, objects).
Result<PointCloudFile> parse_npy(const FileBytes& file);

}  // namespace sightline
