#pragma once

#include "formats/foreign/clouds/points/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

// The parsers behind read_point_cloud(); not for other folders.

namespace sightline {

// Each refuses what contradicts itself; none drops the check for points that were all left out.
Result<PointCloudFile> parse_pcd(const FileBytes& file);
Result<PointCloudFile> parse_ply(const FileBytes& file);
Result<PointCloudFile> parse_las(const FileBytes& file);

}  // namespace sightline
