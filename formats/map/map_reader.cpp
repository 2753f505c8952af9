#include "formats/map/map_reader.h"

#include <algorithm>
#include <utility>

#include "formats/map/map_decoder.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Decoded = std::pair<CompiledMap, MapSummary>;

// Bytes in memory may start anywhere; those of a file do not.
std::vector<double> aligned_copy(std::span<const std::byte> file) {
  std::vector<double> copy(file.size() / sizeof(double) + 1);
  std::copy(file.begin(), file.end(), std::as_writable_bytes(std::span(copy)).begin());
  return copy;
}

MapSummary summary_of(const MapContainer& container, const CompiledMap& map) {
  const FileHeader& header = container.header;
  MapSummary summary;
  summary.format = to_string(header.version);
  summary.writer = map.writer;
  summary.map_id = map.map_id;
  summary.version = map.version;
  summary.release = map.release;
  summary.root_digest = header.root_digest;
  summary.model_digest = map.model.digest;
  summary.file_size = header.file_size;
  summary.manifest_size = header.manifest_size;
  summary.directory_size = header.directory_size;
  summary.tile_count = container.directory->tiles()->size();
  return summary;
}

Result<Decoded> decode_aligned(std::span<const std::byte> file, KeepNds keep_nds) {
  SIGHTLINE_ASSIGN(const MapContainer container, open_container(file));
  MapDecoder decoder(container, keep_nds);
  SIGHTLINE_ASSIGN(CompiledMap map, decoder.run());
  MapSummary summary = summary_of(container, map);
  summary.blocks = decoder.blocks();
  return Decoded(std::move(map), std::move(summary));
}

Result<Decoded> decode_bytes(std::span<const std::byte> file, KeepNds keep_nds) {
  if (reinterpret_cast<std::uintptr_t>(file.data()) % 8 == 0) return decode_aligned(file, keep_nds);
  const std::vector<double> copy = aligned_copy(file);
  return decode_aligned(std::as_bytes(std::span(copy)).first(file.size()), keep_nds);
}

Result<Decoded> decode_file(const std::filesystem::path& path, KeepNds keep_nds) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(path.string()));
  Result<Decoded> decoded = decode_aligned(file.bytes(), keep_nds);
  if (decoded) return decoded;
  Error error = decoded.error();
  error.file = path.string();
  return error;
}

}  // namespace

Result<CompiledMap> read_map(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(Decoded decoded, decode_file(path, KeepNds::kYes));
  return std::move(decoded.first);
}

Result<CompiledMap> read_map(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(Decoded decoded, decode_bytes(file, KeepNds::kYes));
  return std::move(decoded.first);
}

Result<CheckedMap> read_map_without_nds(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(Decoded decoded, decode_file(path, KeepNds::kNo));
  return CheckedMap{std::move(decoded.first), std::move(decoded.second)};
}

Result<MapSummary> verify_map(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(Decoded decoded, decode_file(path, KeepNds::kNo));
  return std::move(decoded.second);
}

Result<MapSummary> verify_map(std::span<const std::byte> file) {
  SIGHTLINE_ASSIGN(Decoded decoded, decode_bytes(file, KeepNds::kNo));
  return std::move(decoded.second);
}

}  // namespace sightline
