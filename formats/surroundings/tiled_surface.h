#pragma once

#include <cstddef>
#include <span>

#include "formats/surroundings/surface.h"
#include "formats/tables/stored_table.h"

namespace sightline {

// A row is a patch.
template <>
struct RowsOf<Surface> {
  static std::size_t size(const Surface& /*head*/) { return kEncodedPatch; }
  static std::size_t count(const Surface& surface) { return surface.patches.size(); }
  static Surface head_of(const Surface& surface);
  // Patches of a whole surface may have any order.
  static Surface in_order(const Surface& whole);
  static Surface part_of(const Surface& head, std::size_t first, std::size_t count);
  static void resize(Surface& head, std::size_t count) { head.patches.resize(count); }
  static void encode_head(const Surface& surface, ByteWriter& writer);
  static void decode_head(ByteReader& reader, Surface& surface);
  static void encode(const Surface& surface, std::size_t first, std::size_t count,
                     ByteWriter& writer);
  static void decode(ByteReader& reader, Surface& surface, std::size_t first, std::size_t count);
  static TileKey tile(const Surface& head, std::span<const std::byte> row);
  // Half the side of the patch.
  static double reach_m(std::span<const std::byte> row);
};

// The patches of a surface, tile by tile.
using TiledSurface = StoredTable<Surface>;

// A surface is an artifact in this form alone.
template <>
struct ArtifactTraits<TiledSurface> {
  static constexpr std::string_view kName = "surface";
  static constexpr std::uint32_t kVersion = 5;
};

}  // namespace sightline
