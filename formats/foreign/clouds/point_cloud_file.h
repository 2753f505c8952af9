#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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
  // time_origin_ns, a time of the file's clock, or after the scan's stamp (times within 2 s of 0).
  // The unit is the one of s, ms, us and ns in which the scan takes 2 ms to 2 s.
  std::vector<std::int32_t> time_offset_ns;
  std::optional<std::int64_t> time_origin_ns;
  // There is a field of times in which no unit makes sense, with a NaN, or with fewer than
  // kFewestTimes different ones for many points; it was left out.
  bool has_unclear_times = false;
  // A field that seems to hold times and was not read, because its name is unknown; else empty.
  std::string unread_time;
  // Position of the sensor in the file (PCD: VIEWPOINT); nothing for the origin.
  std::optional<Eigen::Vector3d> viewpoint_m;
};

// A sweep is measured in packets: so few different times are no times of its points.
inline constexpr std::size_t kFewestTimes = 16;

// Fills time_offset_ns, time_origin_ns and has_unclear_times by the rules given there, from one
// time a point in any unit (known_unit_ns where the format names it) and by any clock.
void set_point_times(std::span<const double> times, PointCloudFile& cloud,
                     std::optional<double> known_unit_ns = std::nullopt);

// Adds a return to the cloud and is true; counts a point that is not a return, and is false.
inline bool add_point(PointCloudFile& cloud, const Eigen::Vector3d& point_m, float intensity) {
  if (!point_m.allFinite()) {
    ++cloud.nonfinite_count;
    return false;
  }
  if (point_m.isZero(0.0)) {
    ++cloud.zero_count;
    return false;
  }
  cloud.points_m.push_back(point_m);
  cloud.intensity.push_back(intensity);
  return true;
}

// Fields that hold the strength of the return, as the usual writers name them.
inline bool is_intensity_name(std::string_view name) {
  return name == "intensity" || name == "Intensity" || name == "scalar_intensity" ||
         name == "scalar_Intensity" || name == "reflectivity" || name == "i";
}

// Fields that hold the time of a point, as the usual drivers name them: t, time, timestamp,
// time_stamp, offset_time, GpsTime and their like in any case, also with a unit at the end
// (timestamp_ns). `curvature` is what FAST-LIO stores a point's time in.
bool is_time_name(std::string_view name);

// Chooses the field of times among the fields of a cloud, which are offered one after the other.
class TimeName {
 public:
  // Whether this is now the field to read: the last one that is_time_name(), `curvature` only where
  // there is no other.
  bool take(std::string_view name);
  // set_point_times() with the numbers of that field, in the unit that its name gives, if any.
  // Without such a field (`times` is then ignored): sets unread_time to the first name with "time"
  // or "stamp" in it.
  void set_times(std::span<const double> times, PointCloudFile& cloud) const;

 private:
  [[nodiscard]] std::optional<double> unit_ns() const;

  std::string name_;
  std::string unread_;
};

}  // namespace sightline
