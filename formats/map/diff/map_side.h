#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "formats/grid/point_grid.h"
#include "formats/map/compiled_map.h"
#include "formats/map/diff/map_diff.h"
#include "formats/reader/map_container.h"

// One of two maps that are compared: what its manifest says, and layers read when they are asked
// for. How much was read is counted.

namespace sightline {

struct SiteRow {
  std::uint32_t site = 0;
  std::uint32_t run = 0;
  double s_m = 0.0;
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();  // map frame
  std::vector<SiteAnswer> answers;                // [limit of the map]
  double longest_virtual_points = 0.0;            // at the longest range
};

// The sites of one tile, and where to look for the nearest of them.
struct TileSites {
  std::vector<SiteRow> rows;
  PointGrid grid;  // of the rows
};

struct NearestSite {
  const SiteRow* row = nullptr;  // none near enough
  double distance_m = 0.0;
};

class MapSide {
 public:
  // The bytes must outlive it. Errors: those of open_container(), bad-manifest.
  static Result<MapSide> open(std::span<const std::byte> file);

  // All but NDs, sites, predictions and choices.
  [[nodiscard]] const CompiledMap& card() const { return card_; }
  [[nodiscard]] const MapContainer& container() const { return container_; }
  [[nodiscard]] std::uint64_t bytes_read() const { return bytes_read_; }
  [[nodiscard]] std::uint64_t nd_count() const;
  [[nodiscard]] std::uint32_t site_count() const;
  [[nodiscard]] std::uint32_t tile_count() const;
  [[nodiscard]] TileKey tile_key(std::uint32_t tile) const;

  // Of a tile of the directory, ascending by cell; none where it has no such layer.
  // Errors: checksum-mismatch, too-large, bad-layer, bad-order.
  Result<std::vector<Nd>> nds(std::uint32_t tile);
  // Kept, so that a layer is read once. Errors: checksum-mismatch, bad-layer.
  Result<const TileSites*> sites(std::uint32_t tile);

  // A column of the card with its values. Errors: checksum-mismatch, too-large, bad-layer.
  Result<SiteColumn> column(const SiteColumn& card);
  // Of its values. The card has a column of this name.
  [[nodiscard]] Digest column_digest(const std::string& name) const;

  // The site nearest to a place in map coordinates, at most `most_m` away, which is at most a tile;
  // of sites equally near the one with the lower number. kSame: on the level of the place.
  enum class Level { kAny, kSame };
  Result<NearestSite> nearest(const Eigen::Vector3d& p_m, double most_m, Level level);

 private:
  explicit MapSide(const MapContainer& container);
  Result<std::vector<std::byte>> raw_bytes(const schema::Block& block);
  Result<void> find_virtual_points();
  Result<void> add_virtual_points(std::uint32_t tile, std::span<const std::uint8_t> range_index,
                                  std::vector<SiteRow>& rows);
  // What nearest() searches for.
  struct Sought {
    const Eigen::Vector3d& p_m;
    double most_m;
    Level level;
  };
  Result<void> search(TileKey key, const Sought& sought, NearestSite& nearest);

  MapContainer container_;
  CompiledMap card_;
  std::map<std::uint32_t, TileSites> sites_;  // by tile
  std::uint64_t bytes_read_ = 0;
  std::uint64_t factor_count_ = 0;
  std::optional<std::uint64_t> virtual_points_;  // column of the factor layers
};

}  // namespace sightline
