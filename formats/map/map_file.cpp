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
  return Error{ErrorCode::kInvalidArtifact, "a map file of another size than its header says", "",
               "map file"};
}

Table dump(const MapFile& file) {
  const Result<std::vector<std::byte>> bytes = file.bytes.read(0, file.bytes.size());
  SIGHTLINE_CHECK(bytes.has_value());
  const Result<CompiledMap> map = read_map(*bytes);
  SIGHTLINE_CHECK(map.has_value());
  return dump(*map);
}

}  // namespace sightline
