#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/map/container/packed_block.h"
#include "formats/surroundings/ndt_map.h"

// Puts a file together from its parts, knowing nothing of what they mean but for the range layers,
// from which it makes what is derived: the layers "contents", the section "look-up" and its
// feature. Parts do not name these.

namespace sightline {

struct FeatureParts {
  std::uint8_t bit = 0;
  bool is_required = false;
  std::string name;
};

// Writes a file from front to back and keeps none of its blocks: of each tile it remembers its
// entry in the directory, of each site one row of the section "look-up".
class ContainerWriter {
 public:
  // Puts bytes at an offset of the file; offsets ascend but for the header, which comes last.
  using Write = std::function<Result<void>(std::uint64_t, std::span<const std::byte>)>;

  ContainerWriter(Write write, std::vector<std::byte> manifest, std::vector<FeatureParts> features);
  ~ContainerWriter();
  ContainerWriter(const ContainerWriter&) = delete;
  ContainerWriter& operator=(const ContainerWriter&) = delete;

  // Tiles by ascending key, layers and sections by ascending name, all tiles before any section.
  // Derived blocks are passed over. Errors: those of `write`.
  Result<void> add_tile(TileKey key, std::span<const PackedBlock> layers);
  Result<void> add_section(const PackedBlock& section);
  // Once. The root digest, which is also in the header.
  Result<Digest> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Writes into memory.
ContainerWriter::Write write_to(std::vector<std::byte>& file);

struct BlockParts {
  std::string name;
  std::uint32_t version = 1;
  bool is_required = true;
  std::uint64_t row_count = 0;
  bool may_compress = true;
  std::vector<std::byte> raw;
  std::optional<StoredBlock> stored = {};  // packed already
};

// A block and the bytes that it points to.
struct SelfContainedBlock {
  StoredBlock stored;
  PackedBlock block;
};
SelfContainedBlock packed(const BlockParts& parts);

struct TileParts {
  TileKey key;
  std::vector<BlockParts> layers;  // ascending name
};

struct ContainerParts {
  std::vector<std::byte> manifest;
  std::vector<TileParts> tiles;      // ascending key
  std::vector<BlockParts> sections;  // ascending name
  std::vector<FeatureParts> features;
};

// The whole file in memory. The same parts give the same bytes.
std::vector<std::byte> assemble(const ContainerParts& parts);

}  // namespace sightline
