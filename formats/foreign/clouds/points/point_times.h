#pragma once

#include <span>
#include <string_view>

#include "formats/foreign/clouds/points/point_cloud_file.h"

namespace sightline {

// Takes the times of a cloud's points as its file has them (one each, any unit, any clock) and
// fills time_offset_ns, time_origin_ns and has_unclear_times by the rules given there.
// Where the format itself names the unit, that is `known_unit_ns`.
void set_point_times(std::span<const double> times, PointCloudFile& cloud,
                     std::optional<double> known_unit_ns = std::nullopt);

}  // namespace sightline
