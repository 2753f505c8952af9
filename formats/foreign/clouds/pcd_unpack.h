#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "formats/foreign/clouds/element_type.h"
#include "formats/foreign/clouds/point_cloud_file.h"

// From the binary body of a file to points, as fast as memory allows: reading a scan is part of
// every match. The caller has checked that the body has the size that its header asks for.

namespace sightline {

// Unpacks an LZF stream (M. Lehmann's liblzf, the packing of PCD's binary_compressed). False where
// the stream is damaged or does not fill `unpacked` to the last byte.
[[nodiscard]] bool unpack_lzf(std::span<const std::uint8_t> packed,
                              std::span<std::uint8_t> unpacked);

// One number of every point as it lies in memory: point after point or column after column.
struct FieldColumn {
  const std::uint8_t* first = nullptr;
  std::size_t stride = 0;  // bytes from one point's to the next
  ElementType type;
};

struct PointColumns {
  std::size_t count = 0;
  std::array<FieldColumn, 3> position;
  std::optional<FieldColumn> intensity;  // 0 where there is none
  std::optional<FieldColumn> time;       // of each point; see set_point_times
  TimeName time_name;
};

// What add_point() does for every point.
PointCloudFile read_points(const PointColumns& columns);

}  // namespace sightline
