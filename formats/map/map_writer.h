#pragma once

#include <cstddef>
#include <vector>

#include "formats/map/compiled_map.h"
#include "formats/map/container_writer.h"

namespace sightline {

// The file of a valid map, as schemas/map_format.md describes it. The same map gives the same
// bytes; no clock, host name or command line enters. NDs are rounded as layers.h says; all else is
// exact.
std::vector<std::byte> encode_map(const CompiledMap& map);

// The same before it is put together: for who adds layers of their own.
ContainerParts parts_of(const CompiledMap& map);

}  // namespace sightline
