#include "compiler/views/report/page/pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "compiler/views/picture/dump_picture.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

// Sites nearer to each other than this tell the same height.
constexpr double kSpotCell_m = 8.0;

std::uint8_t value_of(double height_m) {
  const double steps = (height_m - kReliefLowest_m) / kReliefStep_m;
  return static_cast<std::uint8_t>(1 + std::clamp(std::lround(steps), 0L, 254L));
}

// A patch as a lattice of points, near enough to each other to leave no pixel out.
void draw_patch(const SurfacePatch& patch, double road_m, const MapBox& box, double pixel_m,
                GreyRaster& raster) {
  const Eigen::Vector3d along = side_of(patch);
  const Eigen::Vector3d across = patch.normal.cross(along);
  const int steps = std::max(1, static_cast<int>(std::ceil(2.0 * patch.half_side_m / pixel_m)));
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const double u_m = patch.half_side_m * (2.0 * i / steps - 1.0);
      const double v_m = patch.half_side_m * (2.0 * j / steps - 1.0);
      const Eigen::Vector3d at_m = patch.centre_m + u_m * along + v_m * across;
      const double column = std::floor((at_m.x() - box.low_x_m) / pixel_m);
      const double row = std::floor((box.high_y_m - at_m.y()) / pixel_m);
      if (column < 0.0 || row < 0.0 || column >= raster.width || row >= raster.height) continue;
      std::uint8_t& pixel =
          raster.at(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row));
      pixel = std::max(pixel, value_of(at_m.z() - road_m));
    }
  }
}

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

// Of all images together, as they stand in the page: a long route shows every fourth site's, or
// every tenth's.
constexpr std::size_t kMostBytes = 3'000'000;
constexpr double kLeastSpacing_m = 2.0;   // what is seen a metre on is nearly the same
constexpr std::size_t kSampleCount = 32;  // images from which their size is estimated
constexpr double kNothing = 255.0;
constexpr double kFarthest = 254.0;

std::string image_of(const DepthImages& images, std::size_t site) {
  GreyRaster raster(images.azimuth_count, images.elevation_count);
  for (std::uint32_t row = 0; row < raster.height; ++row) {
    for (std::uint32_t column = 0; column < raster.width; ++column) {
      const std::size_t cell = seen_cell(images, column, row);
      const double share =
          static_cast<double>(images.image_of(site)[cell]) / images.longest_range_m;
      raster.at(column, row) = static_cast<std::uint8_t>(
          share <= 1.0 ? std::lround(kFarthest * share) : std::lround(kNothing));
    }
  }
  return png_base64(raster);
}

// Every how many sites one image is shown.
std::size_t stride_of(const DepthImages& images, double site_spacing_m) {
  const std::size_t step = std::max<std::size_t>(1, images.site_count / kSampleCount);
  std::size_t bytes = 0;
  std::size_t count = 0;
  for (std::size_t site = 0; site < images.site_count; site += step) {
    bytes += image_of(images, site).size();
    ++count;
  }
  const std::size_t all = count == 0 ? 0 : bytes / count * images.site_count;
  const auto least = static_cast<std::size_t>(std::ceil(kLeastSpacing_m / site_spacing_m));
  return std::max(least, all / kMostBytes + 1);
}

}  // namespace

RoadHeight::RoadHeight(const Sites& sites, double sensor_height_m) {
  std::set<TileKey> taken;
  std::vector<Eigen::Vector3d> places_m;
  for (const Site& site : sites.sites) {
    const Eigen::Vector3d& p_m = site.p_map_m;
    if (!taken.insert(tile_key(p_m, kSpotCell_m)).second) continue;
    places_m.emplace_back(p_m.x(), p_m.y(), 0.0);
    heights_m_.push_back(p_m.z() - sensor_height_m);
  }
  places_ = PointGrid(places_m, kSpotCell_m);
}

double RoadHeight::at(double x_m, double y_m) const {
  const std::optional<NearPoint> nearest =
      places_.nearest({x_m, y_m, 0.0}, std::numeric_limits<double>::infinity());
  return nearest ? heights_m_[nearest->index] : 0.0;
}

GreyRaster relief_picture(const Surface& surface, const std::vector<std::size_t>& patches,
                          const RoadHeight& road, const MapBox& box, double pixel_m) {
  const auto pixels = [&](double length_m) {
    return static_cast<std::uint32_t>(std::max(1.0, std::ceil(length_m / pixel_m - 1e-9)));
  };
  GreyRaster raster(pixels(box.width_m()), pixels(box.height_m()));
  for (const std::size_t i : patches) {
    const SurfacePatch& patch = surface.patches[i];
    draw_patch(patch, road.at(patch.centre_m.x(), patch.centre_m.y()), box, pixel_m, raster);
  }
  return raster;
}

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

PageJson depth_json(const DepthImages& images, double site_spacing_m) {
  const std::size_t stride = stride_of(images, site_spacing_m);
  std::vector<std::uint32_t> sites;
  std::vector<std::string> texts;
  for (std::size_t site = 0; site < images.site_count; site += stride) {
    sites.push_back(static_cast<std::uint32_t>(site));
    texts.push_back(image_of(images, site));
  }
  const double to_rad = std::numbers::pi / 180.0;
  return {{"site", json_numbers(sites)},
          {"columns", images.azimuth_count},
          {"rows", images.elevation_count},
          {"first_elevation_rad", images.first_elevation_deg * to_rad},
          {"elevation_step_rad", images.elevation_step_deg * to_rad},
          {"longest_m", images.longest_range_m},
          {"images", texts}};
}

}  // namespace sightline
