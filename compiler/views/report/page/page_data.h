#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compiler/views/report/page/report_sources.h"

// The numbers of a page: one JSON object in <script type="application/json" id="data">. "<" is
// written \u003c. Lengths are m and angles rad in the map frame unless a name says otherwise.
//
// An array is an object {"type", "count", "data"}: `data` is base64 of a zlib stream of the
// elements' little-endian bytes by planes (packed.h); types are u8, u16, u32, f32, f64. Arrays of
// several indices are written as [slowest]...[fastest].
//
//   ranges_m, limits_m, site_spacing_m, selection, dilation_m, thresholds: of the map
//   origin_world_m: of the map frame, [x, y, z]
//   sites      count; x_m, y_m, z_m, s_m, heading_rad (f64), run (u32); route_m: way from the first
//              site with all runs laid end to end
//   predicted  mean_m [site][range], probability [site][range][limit] (f32);
//              extrapolated [site][range]
//   choice     range_index, flags [site][limit]
//              (u8; bit 0 unmet, bit 1 extrapolated, bit 4 static)
//   judged     (where a drive judged) drive, rules (names), site [judged] (u32), error_m, time_ms
//              [judged][range] (f32), chosen [limit][rule][judged] (u8)
//   factors    names, values, of four digits [site][range][factor] (f32), median, deviation
//              [range][factor] (f64)
//   texts      sites_per_block and blocks: a zlib stream each of what `inspect --site` says, one
//              text after the other, each ended by a 0 byte
//   depth      (where known) site: those that have an image, 2 m apart or farther (u32); columns,
//   rows,
//              first_elevation_rad, elevation_step_rad, longest_m; images: base64 of a PNG of greys
//              for each, rows from the highest elevation down, columns by azimuth from -x over -y,
//              +x and +y: columns/2 is map +x, to its left +y; grey 0 to 254 is distance /
//              longest_m, 255 nothing within it
//   nds        cell_m, tile_m, lowest_z_m, tiles: {x, y (key), count, place_m [nd][2] (u16, from
//   the tile's lower
//              corner, 1 = tile_m / 65535), height (u16, over lowest_z_m, 1 cm), radius [nd][2]
//              (u16, the longer and shorter half axis of two standard deviations from above, mm),
//              turn (u8, of the longer from +x, 1 = pi / 256), kind (u8: 1 line, 2 standing plane,
//              3 volume, 4 lying plane)}
//   relief     (where the surface is known) lowest_m, step_m; overview: {low_x_m, high_y_m,
//   pixel_m,
//              image}; tile_m and tiles: {x, y, image}. Images are base64 PNGs of greys, north up:
//              0 nothing, else 1 + (height over the road - lowest_m) / step_m
//   moved      (where known) voxel_m, tile_m, tiles: {x, y, count, cell [column][2] (u16, voxels
//   from
//              the tile's lower corner), height (u8: voxels in the column)}
//   diff       (where an older map is known) limits_m: of both maps; sites: site (u32), change (u8:
//   0
//              added, 2 changed), before_dm, after_dm [site][limit] (u16, chosen ranges in 0.1 m; 0
//              where the site is new); nds: stride (of so many one is here), x_m, y_m (f32), change
//              (u8: 0 added, 1 removed, 2 moved)

namespace sightline {

using PageJson = nlohmann::ordered_json;

std::string page_data_json(const ReportSources& sources);

// The parts.
PageJson sites_json(const CompiledMap& map);
PageJson predicted_json(const CompiledMap& map);
PageJson choice_json(const CompiledMap& map);
PageJson judged_json(const Evaluation& evaluation);
PageJson factors_json(const CompiledMap& map);
PageJson texts_json(const CompiledMap& map);
PageJson depth_json(const DepthImages& images, double site_spacing_m);
PageJson nds_json(const NdtMap& map);
PageJson relief_json(const Surface& surface, const Sites& sites, double sensor_height_m);
PageJson moved_json(const SurfacePoints& points, double tile_m);
PageJson diff_json(const MapDiff& diff, const MapFrame& frame);

}  // namespace sightline
