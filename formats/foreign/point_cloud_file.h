#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "compiler/base/result.h"

namespace sightline {

// One point cloud as somebody else's program wrote it, in the file's own frame, metres. Points with
// a NaN or infinite coordinate and points at exactly (0,0,0) (no return) are left out and counted.
struct PointCloudFile {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<float> intensity;  // one per point; 0 where the file has none
  std::uint64_t nonfinite_count = 0;
  std::uint64_t zero_count = 0;
  // A text file whose last line has no end: its last number may have lost digits.
  bool may_be_cut = false;
};

// Reads PCD (ascii, binary, binary_compressed; versions up to 0.7; any order of fields, any field
// types, extra fields), PLY (ascii, binary of both byte orders) and KITTI .bin (x y z intensity as
// float32, no header). Coordinates keep the precision that the file has: doubles and the decimal
// digits of text stay double. A file is checked against its own header and size before any of it is
// believed, so a damaged one is refused and never crashes.
//
// Errors, with the byte or line: file-not-found, cannot-open, cannot-read, git-lfs-pointer,
// unsupported-format (LAS, LAZ, E57, archives, nuScenes .bin, ...; says how to convert),
// malformed-header, malformed-text, missing-field (no x, y or z), truncated-scan, empty-scan (no
// points at all), no-finite-points (every point was dropped).
Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path);

// The same from bytes that were read already; `path` decides between formats without a signature
// and names the file in errors.
Result<PointCloudFile> parse_point_cloud(std::span<const std::byte> bytes,
                                         const std::filesystem::path& path);

}  // namespace sightline
