#include "compiler/views/picture/dump_picture.h"

#include <cstdio>

#include "compiler/views/picture/depth_picture.h"
#include "compiler/views/picture/png.h"
#include "compiler/views/picture/points_picture.h"
#include "compiler/views/picture/ranges_picture.h"

namespace sightline {
namespace {

Error bad(std::string message) { return {ErrorCode::kBadArgument, std::move(message)}; }

Result<std::string> png_text(const Raster& raster) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> file, encode_png(raster));
  return std::string(reinterpret_cast<const char*>(file.data()), file.size());
}

Result<std::string> draw_depth(const PictureRequest& request, const DepthImages& depth) {
  if (request.format != PictureFormat::kPng) return bad("--format: a depth image is drawn as png");
  if (request.site < 0 || static_cast<std::uint32_t>(request.site) >= depth.site_count) {
    return bad("--site: a depth image needs one of 0 to " +
               std::to_string(static_cast<std::int64_t>(depth.site_count) - 1));
  }
  return png_text(depth_picture(depth, static_cast<std::size_t>(request.site)));
}

Result<void> check_extent(const MapBox& box) {
  if (box.high_x_m > box.low_x_m && box.high_y_m > box.low_y_m) return {};
  return bad("--box: the second corner must lie to the right of the first and above it");
}

Result<std::string> draw_nds(const PictureRequest& request, const NdtMap& ndt, const Sites& sites) {
  const MapBox box = request.box ? *request.box : box_around(ndt);
  SIGHTLINE_TRY(check_extent(box));
  if (request.format == PictureFormat::kSvg) return ndt_picture_svg(ndt, sites, box);
  return png_text(ndt_picture(ndt, sites, box));
}

// What stood still in grey, what was removed in red.
Result<std::string> draw_points(const PictureRequest& request, const SurfacePoints& points) {
  if (request.format != PictureFormat::kPng) return bad("--format: points are drawn as png");
  SIGHTLINE_ASSIGN(const Raster raster, points_picture(points));
  return png_text(raster);
}

Result<std::string> draw_ranges(const PictureRequest& request, const PictureSources& sources) {
  if (request.format != PictureFormat::kSvg) return bad("--format: ranges are drawn as svg");
  const MapBox box = request.box ? *request.box : ranges_picture_box(sources.sites);
  SIGHTLINE_TRY(check_extent(box));
  return ranges_picture_svg(*sources.ndt, sources.sites, *sources.ranges, box);
}

}  // namespace

Result<MapBox> parse_box(const std::string& text) {
  MapBox box;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &box.low_x_m, &box.low_y_m, &box.high_x_m,
                  &box.high_y_m, &rest) != 4) {
    return bad("--box: found \"" + text + "\", expected x0,y0,x1,y1 in m");
  }
  return box;
}

Result<std::string> draw_picture(const PictureRequest& request, const PictureSources& sources) {
  if (request.what == "depth" && sources.depth) return draw_depth(request, *sources.depth);
  if (request.what == "nds" && sources.ndt) return draw_nds(request, *sources.ndt, sources.sites);
  if (request.what == "points" && sources.points) return draw_points(request, *sources.points);
  if (request.what == "ranges" && sources.ranges) return draw_ranges(request, sources);
  return bad(
      "--format: pictures are made of depth and points (of a configuration), of nds and of ranges, "
      "not of \"" +
      request.what + "\" here");
}

}  // namespace sightline
