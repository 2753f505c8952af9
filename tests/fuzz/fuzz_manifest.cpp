// The input is a manifest: it is put into a small map whose tiles are sound, with every checksum
// and digest right, and must be refused or describe a map that can be used.

#include "compiler/views/text/describe.h"
#include "formats/base/check.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/reader.h"
#include "tests/formats/map/random_map.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

const ContainerParts& sound_parts() {
  static const ContainerParts parts = [] {
    ContainerParts made = parts_of(random_map({.seed = 2, .site_count = 3, .nd_count = 4}));
    for (TileParts& tile : made.tiles) {
      for (BlockParts& layer : tile.layers) layer.may_compress = false;
    }
    for (BlockParts& section : made.sections) section.may_compress = false;
    return made;
  }();
  return parts;
}

void use(std::span<const std::byte> file) {
  const Result<MapReader> reader = MapReader::open(file, "annealed");
  if (reader) (void)reader->observation_range(reader->info().origin_world_m, 0.1);
  const Result<CompiledMap> map = read_map(file);
  if (!map) return;
  SIGHTLINE_CHECK(reader.has_value());
  SIGHTLINE_CHECK(!describe(*map).empty());
  SIGHTLINE_CHECK(!dump(*map).rows.empty());
  SIGHTLINE_CHECK(read_map(encode_map(*map)).has_value());
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  sightline::ContainerParts parts = sightline::sound_parts();
  const auto bytes = std::as_bytes(std::span(data, size));
  parts.manifest.assign(bytes.begin(), bytes.end());
  sightline::use(sightline::assemble(parts));
  return 0;
}
