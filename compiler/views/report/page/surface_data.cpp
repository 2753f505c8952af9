#include <algorithm>
#include <map>

#include "compiler/views/picture/png.h"
#include "compiler/views/picture/relief.h"
#include "compiler/views/report/page/json_numbers.h"
#include "compiler/views/report/page/page_data.h"
#include "compiler/views/report/page/pictures.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

constexpr double kTilePixel_m = 0.25;
constexpr double kOverviewSide_px = 4096.0;
constexpr double kOverviewFinest_m = 1.0;  // what is nearer is drawn of tiles

// Never fails: no raster here is without pixels.
std::string png_base64(const GreyRaster& raster) {
  const Result<std::vector<std::byte>> file = encode_png(raster);
  SIGHTLINE_CHECK(file.has_value());
  return base64_of(*file);
}

PageJson relief_tiles(const Surface& surface, const RoadHeight& road) {
  std::map<TileKey, std::vector<std::size_t>> patches;
  for (std::size_t i = 0; i < surface.patches.size(); ++i) {
    patches[tile_key(surface.patches[i].centre_m, surface.tile_m)].push_back(i);
  }
  PageJson tiles = PageJson::array();
  for (const auto& [key, indices] : patches) {
    const MapBox box = {key.x * surface.tile_m, key.y * surface.tile_m,
                        (key.x + 1) * surface.tile_m, (key.y + 1) * surface.tile_m};
    tiles.push_back(
        {{"x", key.x},
         {"y", key.y},
         {"image", png_base64(relief_picture(surface, indices, road, box, kTilePixel_m))}});
  }
  return tiles;
}

}  // namespace

std::optional<Overview> relief_overview(const Surface& surface, const Sites& sites,
                                        double sensor_height_m) {
  if (surface.patches.empty()) return std::nullopt;
  Eigen::AlignedBox2d around;
  std::vector<std::size_t> all;
  for (const SurfacePatch& patch : surface.patches) {
    around.extend(patch.centre_m.head<2>());
    all.push_back(all.size());
  }
  Overview overview;
  overview.box = {around.min().x(), around.min().y(), around.max().x(), around.max().y()};
  overview.pixel_m = std::max(kOverviewFinest_m, around.sizes().maxCoeff() / kOverviewSide_px);
  const RoadHeight road(sites, sensor_height_m);
  overview.png_base64 =
      png_base64(relief_picture(surface, all, road, overview.box, overview.pixel_m));
  return overview;
}

PageJson relief_json(const Surface& surface, const Sites& sites, double sensor_height_m) {
  const std::optional<Overview> overview = relief_overview(surface, sites, sensor_height_m);
  const RoadHeight road(sites, sensor_height_m);
  PageJson json = {{"lowest_m", kReliefLowest_m}, {"step_m", kReliefStep_m}};
  if (overview) {
    json["overview"] = {{"low_x_m", overview->box.low_x_m},
                        {"high_y_m", overview->box.high_y_m},
                        {"pixel_m", overview->pixel_m},
                        {"image", overview->png_base64}};
  }
  json["tile_m"] = surface.tile_m;
  json["tiles"] = relief_tiles(surface, road);
  return json;
}

PageJson moved_json(const SurfacePoints& points, double tile_m) {
  // Columns of voxels by tile; voxels lie ascending, so those of a column follow each other only
  // by accident.
  std::map<TileKey, std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint8_t>> tiles;
  for (const CellKey& key : points.moved_voxels) {
    const Eigen::Vector3d centre_m = cell_centre_m(key, points.voxel_m);
    const TileKey tile = tile_key(centre_m, tile_m);
    const auto steps = [&](double at_m, std::int32_t tile_index) {
      return static_cast<std::uint16_t>((at_m - tile_index * tile_m) / points.voxel_m);
    };
    std::uint8_t& height = tiles[tile][{steps(centre_m.x(), tile.x), steps(centre_m.y(), tile.y)}];
    if (height < 255) ++height;
  }
  PageJson made = PageJson::array();
  for (const auto& [key, columns] : tiles) {
    std::vector<std::uint16_t> cell;
    std::vector<std::uint8_t> height;
    for (const auto& [at, voxels] : columns) {
      cell.insert(cell.end(), {at.first, at.second});
      height.push_back(voxels);
    }
    made.push_back({{"x", key.x},
                    {"y", key.y},
                    {"count", height.size()},
                    {"cell", json_numbers(cell)},
                    {"height", json_numbers(height)}});
  }
  return {{"voxel_m", points.voxel_m}, {"tile_m", tile_m}, {"tiles", made}};
}

}  // namespace sightline
