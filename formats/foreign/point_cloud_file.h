#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
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
  // When each point was measured, one per point; empty where the file does not say. ns after
  // time_origin_ns, which is a time of the file's own clock, or after the scan's stamp where the
  // file counts from there (times within 2 s of 0). Files name no unit: it is the one of s, ms, us
  // and ns in which the scan takes between 2 ms and 2 s.
  std::vector<std::int32_t> time_offset_ns;
  std::optional<std::int64_t> time_origin_ns;
  // There is a field of times in which no unit makes sense, or with a NaN; it was left out.
  bool has_unclear_times = false;
};

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
