#include "formats/foreign/clouds/pcd_writer.h"

#include <string>

#include "formats/base/bytes.h"

namespace sightline {

static_assert(sizeof(PointXyzi) == 16, "points are written as they lie");

Result<void> write_pcd_binary(const std::filesystem::path& path, std::span<const PointXyzi> points,
                              IfExists if_exists) {
  const std::string count = std::to_string(points.size());
  const std::string header = concat(
      "# .PCD v0.7 - Point Cloud Data file format\n"
      "VERSION 0.7\n"
      "FIELDS x y z intensity\n"
      "SIZE 4 4 4 4\n"
      "TYPE F F F F\n"
      "COUNT 1 1 1 1\n"
      "WIDTH ",
      count,
      "\n"
      "HEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\n"
      "POINTS ",
      count,
      "\n"
      "DATA binary\n");
  ByteWriter writer;
  writer.append(header.data(), header.size());
  writer.append(points.data(), points.size_bytes());
  return write_file_atomically(path, writer.bytes(), if_exists);
}

}  // namespace sightline
