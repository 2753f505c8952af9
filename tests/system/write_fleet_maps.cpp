// Maps for the fleet's tests: write_fleet_maps FOLDER writes v1, v2 (one tile of v1 changed), v3,
// and what an attacker could make of them, with every checksum right:
//   mixed    a tile of v1 among those of v2, under v2's root digest
//   swapped  the two layers of a tile in each other's place
//   bomb     a layer that says it unpacks to more than any layer may
//   inflated a layer whose frame holds more than its directory says

#include <algorithm>
#include <cstdio>
#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_layout.h"
#include "tests/formats/map/random_map.h"
#include "tests/fuzz/repair_map.h"

namespace sightline {
namespace {

CompiledMap map_of(std::uint64_t release) {
  CompiledMap map = random_map({.seed = 11, .site_count = 60, .nd_count = 400});
  map.release = release;
  map.version = "2026." + std::to_string(release);
  for (std::size_t i = 0; i < 20; ++i) {
    map.ndt.nds[i].point_count += static_cast<std::uint32_t>(release - 1);
  }
  return map;
}

// The same map under a root digest that is not its own, all else sealed anew.
std::vector<std::byte> under_root_of(std::vector<std::byte> file,
                                     std::span<const std::byte> other) {
  const Result<FileHeader> wanted = decode_header(other);
  if (!wanted) return {};
  repair_map(file, wanted->root_digest);
  return file;
}

// Every number of 8 bytes in the directory that is `from` becomes `to`, all else is sealed
// anew: an entry of a block then says something else.
std::vector<std::byte> with_number(std::vector<std::byte> file, std::uint64_t from,
                                   std::uint64_t to) {
  const Result<FileHeader> header = decode_header(file);
  if (!header) return {};
  for (std::uint64_t i = 0; i + 8 <= header->directory_size; i += 4) {
    std::byte* place = file.data() + header->directory_offset + i;
    if (std::memcmp(place, &from, 8) == 0) std::memcpy(place, &to, 8);
  }
  repair_map(file);
  return file;
}

bool write(const std::string& path, const std::vector<std::byte>& bytes) {
  const Result<void> written = write_file_atomically(path, bytes, IfExists::kReplace);
  if (!written) std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return written && !bytes.empty();
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2) return 64;
  const std::string folder = std::string(argv[1]) + "/";
  const ContainerParts one = parts_of(map_of(1));
  const ContainerParts two = parts_of(map_of(2));
  const std::vector<std::byte> v2 = assemble(two);

  ContainerParts mixed = two;
  mixed.tiles.front() = one.tiles.front();
  ContainerParts swapped = two;
  std::swap(swapped.tiles[0].layers.front().raw, swapped.tiles[0].layers.back().raw);
  ContainerParts bomb = two;
  BlockParts& layer = bomb.tiles[0].layers.front();
  std::fill(layer.raw.begin(), layer.raw.end(), std::byte{0});
  const std::vector<std::byte> packed = assemble(bomb);
  const std::uint64_t size = layer.raw.size();

  const bool is_written =
      write(folder + "v1.slmap", assemble(one)) && write(folder + "v2.slmap", v2) &&
      write(folder + "v3.slmap", encode_map(map_of(3))) &&
      write(folder + "mixed.slmap", under_root_of(assemble(mixed), v2)) &&
      write(folder + "swapped.slmap", assemble(swapped)) &&
      write(folder + "bomb.slmap", with_number(packed, size, std::uint64_t{1} << 40)) &&
      write(folder + "inflated.slmap", with_number(packed, size, size / 2));
  return is_written ? 0 : 1;
}
