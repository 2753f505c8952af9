#pragma once

#include <optional>

#include "formats/foreign/clouds/floats/float_columns.h"
#include "formats/foreign/clouds/floats/float_counts.h"
#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {

// Float32 without a header: KITTI's four floats a point, nuScenes' five, and others. Where no
// columns are given the number of floats a point is found from the floats. Errors: those of
// parse_point_cloud.
Result<PointCloudFile> parse_float_bin(const FileBytes& file,
                                       const std::optional<FloatColumns>& given);

// Counts of floats a point that fit; of several only nuScenes' five where the name is one of theirs
// (.pcd.bin).
FloatCounts fitting_counts(const FileBytes& file);

}  // namespace sightline
