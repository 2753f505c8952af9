#include "formats/map/map_file.h"

#include <algorithm>
#include <vector>

#include "formats/map/map_reader.h"
#include "formats/reader/map_layout.h"

namespace sightline {

Result<void> validate(const MapFile& file) {
  // No map file is shorter.
  constexpr std::uint64_t kLeast = kHeaderSize + kTrailerSize;
  SIGHTLINE_ASSIGN(const std::vector<std::byte> start,
                   file.bytes.read(0, std::min(kLeast, file.bytes.size())));
  SIGHTLINE_ASSIGN(const FileHeader header, decode_header_alone(start));
  if (header.file_size == file.bytes.size()) return {};
  return Error{ErrorCode::kInvalidArtifact,
               "the size of the map file differs from that in its header", "", "map file"};
}

Result<Table> dump(const MapFile& file) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, file.bytes.read(0, file.bytes.size()));
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(bytes));
  return dump(map);
}

}  // namespace sightline
