#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/artifact_in_pieces.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/surroundings/ndt_map.h"

namespace sightline {

// The NDs of one tile, as places among all NDs.
struct NdTile {
  TileKey key;
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

// An NdtMap of which tiles are read when they are looked at, so that a street of any length takes
// no more memory than a stretch of it. The same bytes as the map's. Safe from several threads.
class TiledNds {
 public:
  TiledNds() = default;
  // Who has a map whole may hand it over where one in tiles is taken: it stays in memory.
  TiledNds(const NdtMap& whole);  // NOLINT(google-explicit-constructor)

  // All but the NDs themselves.
  [[nodiscard]] const NdtMap& head() const { return head_; }
  [[nodiscard]] const MapFrame& frame() const { return head_.frame; }
  [[nodiscard]] double cell_m() const { return head_.cell_m; }
  [[nodiscard]] double tile_m() const { return head_.tile_m; }
  [[nodiscard]] std::uint64_t nd_count() const;
  // That hold NDs, ascending by key.
  [[nodiscard]] std::span<const NdTile> tiles() const { return tiles_; }

  // The NDs of one tile in their order, without counts. Error: cannot-read, as of all that follow.
  [[nodiscard]] Result<NdtMap> tile(const NdTile& tile) const;
  // What nds_over() says of the whole map.
  [[nodiscard]] Result<NdtMap> over(const Eigen::AlignedBox2d& box_m) const;
  [[nodiscard]] Result<NdtMap> whole() const;

 private:
  friend class TiledNdsWriter;
  friend Result<void> visit_payload(const TiledNds& nds, const ByteSink& sink);
  friend std::uint64_t payload_size(const TiledNds& nds);
  friend Result<void> open_payload(const StoredBytes& payload, TiledNds& nds);

  [[nodiscard]] Result<void> append(std::uint64_t first, std::uint64_t count, NdtMap& map) const;
  // The next NDs, ascending.
  void add_to_tiles(const TileKey& key, std::uint64_t count);

  NdtMap head_;
  std::vector<NdTile> tiles_;
  StoredBytes nds_;  // encoded, one after another
};

// Makes one tile after another.
class TiledNdsWriter {
 public:
  // In memory as far as they are few: a kilometre or two.
  static constexpr std::size_t kMostInMemory = std::size_t{2} << 20;
  explicit TiledNdsWriter(std::size_t most_in_memory = kMostInMemory) : bytes_(most_in_memory) {}

  // NDs of one tile, ascending by key; tiles ascend too. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<void> add(const TileKey& key, std::span<const Nd> nds);
  // `head`: all but the NDs.
  [[nodiscard]] TiledNds take(const NdtMap& head);

 private:
  TiledNds made_;
  GrowingBytes bytes_;
};

// A form of the NdtMap.
template <>
struct ArtifactTraits<TiledNds> {
  using Artifact = NdtMap;
  static constexpr std::string_view kName = ArtifactTraits<NdtMap>::kName;
  static constexpr std::uint32_t kVersion = ArtifactTraits<NdtMap>::kVersion;
};

// Reads every tile.
Result<void> validate(const TiledNds& nds);
Table dump(const TiledNds& nds);

std::uint64_t payload_size(const TiledNds& nds);
Result<void> visit_payload(const TiledNds& nds, const ByteSink& sink);
Result<void> open_payload(const StoredBytes& payload, TiledNds& nds);

// NDs as they are encoded one after another, ascending or not, and back.
std::vector<std::byte> encoded_nds(std::span<const Nd> nds);
inline constexpr std::size_t kEncodedNd = 4 * sizeof(std::int32_t) + 9 * sizeof(double);
// Appends to the map. The bytes are those of whole NDs.
void append_nds(std::span<const std::byte> bytes, NdtMap& map);

}  // namespace sightline
