#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace sightline {

// One point cloud as somebody else's program wrote it, in the file's own frame, metres. Points with
// a NaN or infinite coordinate and points at exactly (0,0,0) (no return) are left out and counted.
struct PointCloudFile {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<float> intensity;  // one per point; 0 where the file has none
  std::uint64_t nonfinite_count = 0;
  std::uint64_t zero_count = 0;
  // Points that the file itself marks as not to be used (LAS: withheld); left out too.
  std::uint64_t withheld_count = 0;
  // Floats a point of a file that does not say it itself (.bin); 0: the file says it.
  std::size_t float_count = 0;
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

}  // namespace sightline
