#pragma once

#include <cstdint>
#include <span>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/recording/recording.h"

// Times of points and the times of scans.

namespace sightline {

// The usual time between two scans, ns, in two decimal digits, so that a scan more or less changes
// nothing; 0 where there are fewer than two.
std::int64_t usual_step_ns(std::span<const RecordedScan> scans);

// What was found of a scan's times of points.
enum class PointTimesKind {
  kOfStamp,     // they are around the stamp, or there are none
  kOtherClock,  // they are another clock's, and begin at the stamp now
  kShares,      // they were shares of the sweep, from 0 to 1, and are times now
  kTooLong,     // they last longer than scans are apart, and are removed
};

struct SettledTimes {
  PointTimesKind kind = PointTimesKind::kOfStamp;
  std::int64_t ahead_ns = 0;  // kOtherClock: of the first point, after the stamp
  std::int64_t span_ns = 0;   // of the times as they were
};

// Times of points become offsets from the scan's stamp. A sweep is not longer than the step between
// scans (usual_step_ns; 0: not known): times from 0 to 1 s of scans that are closer are shares of
// the sweep, and those that last 2.5 steps are no times of one sweep. Points belong to their stamp:
// times that begin later after it, or end earlier before it, than a sweep lasts are another clock's
// (without a step: 2 s) and give only the times between points.
SettledTimes settle_point_times(std::int64_t stamp_ns, std::int64_t step_ns, PointCloudFile& cloud);

}  // namespace sightline
