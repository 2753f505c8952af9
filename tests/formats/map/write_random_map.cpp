// Writes a made-up map and what `dump` prints of it: write_random_map SEED FOLDER [KIND]
// KIND: plain (unpacked), small-plain (of a small map, unpacked), small.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/map/container/container_writer.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc < 3 || argc > 4) return 64;
  const std::string kind = argc == 4 ? argv[3] : "plain";
  RandomMapOptions options;
  options.seed = std::strtoull(argv[1], nullptr, 10);
  options.site_count = 120;
  options.nd_count = 300;
  options.size = kind == "plain" ? MapSize::kFull : MapSize::kPromise;
  ContainerParts parts = parts_of(random_map(options));
  for (TileParts& tile : parts.tiles) {
    for (BlockParts& layer : tile.layers) {
      if (kind == "small") break;
      layer.may_compress = false;  // for a reader without zstd
      layer.stored.reset();
    }
  }
  const std::vector<std::byte> file = assemble(parts);
  const Result<CompiledMap> map = read_map(file);
  if (!map) return 1;
  const std::string folder = std::string(argv[2]) + "/";
  Result<void> written = write_file_atomically(folder + "map.slmap", file, IfExists::kReplace);
  for (const char* name : {"nds", "sites", "predicted", "ranges"}) {
    if (!written) break;
    written = write_file_atomically(folder + name + ".json",
                                    format_table(*dump(*map, name), TableFormat::kJson),
                                    IfExists::kReplace);
  }
  if (!written) std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return written ? 0 : 1;
}
