#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <span>

#include "formats/annotation/sites.h"
#include "formats/base/bytes.h"
#include "formats/base/hash.h"
#include "formats/grid/cell_key.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"

namespace sightline {

// What lies where, tile by tile, so that a part of the work can name all that it may depend on
// (PartedWork::content) without reading it again.
class TileDigests {
 public:
  explicit TileDigests(double tile_m) : tile_m_(tile_m) {}

  // Something that lies at a place. Equal things in equal order make equal digests.
  void add(const Eigen::Vector3d& at_m, std::span<const std::byte> bytes);
  // After the last add() and before the first within().
  void finish();

  // All that lies over the box, and in the rest of the tiles that it touches.
  [[nodiscard]] Digest within(const Eigen::AlignedBox2d& box_m) const;

 private:
  double tile_m_;
  std::map<TileKey, DigestBuilder> growing_;
  std::map<TileKey, Digest> of_tile_;
};

// Of NDs at their means; cell and tile edges of the map are in every digest. Error: cannot-read.
Result<TileDigests> digests_of(const TiledNds& nds);
// Of patches at their centres. Error: cannot-read.
Result<TileDigests> digests_of(const TiledSurface& surface);

// All that decides what is seen from a site: where the vehicle and its sensor are.
void put_place(const Site& site, ByteWriter& writer);

// The places in the plane, and `reach_m` around them. At least one place.
Eigen::AlignedBox2d box_around(std::span<const Eigen::Vector3d> places_m, double reach_m);

}  // namespace sightline
