#pragma once

#include <cstddef>
#include <cstdint>

#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/text/file_bytes.h"

// What a LAS file says of the space that its coordinates lie in; not for other folders.

namespace sightline {

// Where the header says that variable length records lie.
struct LasRecordPlaces {
  std::size_t first = 0;  // byte behind the header
  std::size_t count = 0;
  std::size_t end = 0;               // byte of the first point
  std::uint64_t extended_first = 0;  // of LAS 1.4, behind the points
  std::size_t extended_count = 0;
};

// Refuses (unsupported-format, says how to convert) coordinates that are no lengths in metres along
// three axes at right angles: longitude and latitude in degrees, geocentric ones (whose z is not
// up) and feet. A file that says nothing of them passes, and so does one whose records are damaged.
Result<void> check_reference(const FileBytes& file, const LasRecordPlaces& places);

// Degrees in a file that does not say so: x and y within a dm of each other, scaled finer than 10
// um, and inside 360 by 90. No scan of a LiDAR fits into a box of 10 cm; in degrees it is 11 km.
Result<void> check_extent(const FileBytes& file, const PointCloudFile& cloud,
                          const Eigen::Vector3d& scale);

}  // namespace sightline
