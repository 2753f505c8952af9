#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "compiler/views/picture/ndt_picture.h"
#include "compiler/views/picture/raster.h"
#include "formats/annotation/range_table.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface_points.h"

namespace sightline {

// What a site sees, as a person would who stands there: map +x in the middle, +y to its left, up is
// up; one square of pixels a cell, near is warm and far is cold, grey is nothing within the longest
// range. Below it a scale from 0 to the longest range with a notch every 10 m. `site` is in bounds.
Raster depth_picture(const DepthImages& images, std::size_t site);

// The cell of an image in a column from the left and a row from the top: azimuths grow to the left,
// and half a turn lies left of the middle.
std::size_t seen_cell(const DepthImages& images, std::uint32_t column, std::uint32_t row);

// The colour of a distance, for a scale that ends at longest_m.
Colour colour_of_distance(double distance_m, double longest_m);

enum class PictureFormat { kPng, kSvg };

// The contents and the form of a picture.
struct PictureRequest {
  std::string what;  // "depth", "nds", "points" or "ranges"
  PictureFormat format = PictureFormat::kPng;
  int site = -1;              // of a depth image; below 0: none named
  std::optional<MapBox> box;  // of NDs and ranges; without one all of them
};

// What the target of a dump holds of that which can be drawn; null where it is not there.
struct PictureSources {
  std::shared_ptr<const DepthImages> depth;
  std::shared_ptr<const NdtMap> ndt;
  std::shared_ptr<const SurfacePoints> points;
  std::shared_ptr<const RangeTable> ranges;
  Sites sites;  // none where they are not known
};

// "x0,y0,x1,y1" in map coordinates, m. Error: bad-argument.
Result<MapBox> parse_box(const std::string& text);

// The bytes of the picture's file. Errors: bad-argument (no such picture, no such site, a box of no
// extent).
Result<std::string> draw_picture(const PictureRequest& request, const PictureSources& sources);

}  // namespace sightline
