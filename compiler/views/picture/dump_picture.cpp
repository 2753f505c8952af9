#include "compiler/views/picture/dump_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "compiler/views/picture/ranges_picture.h"

namespace sightline {
namespace {

constexpr Colour kPaper = {255, 255, 255};
constexpr std::uint32_t kPixelsPerCell = 4;
constexpr std::uint32_t kScaleHeight = 16;
constexpr std::uint32_t kScaleGap = 4;
constexpr double kNotch_m = 10.0;
constexpr Colour kNothing = {60, 60, 60};
constexpr Colour kInk = {0, 0, 0};

// Equal steps of a scale whose brightness falls all the way, so that it also reads in grey.
constexpr std::array<Colour, 6> kScale = {{{255, 240, 170},
                                           {254, 190, 90},
                                           {240, 110, 60},
                                           {190, 45, 100},
                                           {105, 30, 130},
                                           {30, 15, 90}}};

void draw_scale(double longest_m, std::uint32_t first_row, Raster& raster) {
  for (std::uint32_t column = 0; column < raster.width; ++column) {
    const double from_m = longest_m * column / raster.width;
    const double to_m = longest_m * (column + 1) / raster.width;
    const bool is_notch = std::floor(from_m / kNotch_m) != std::floor(to_m / kNotch_m);
    for (std::uint32_t row = first_row; row < first_row + kScaleHeight; ++row) {
      raster.at(column, row) = is_notch ? kInk : colour_of_distance(from_m, longest_m);
    }
  }
}

constexpr double kFinest_m = 0.2;
constexpr double kMost_pixels = 4000.0;
constexpr Colour kRemoved{214, 39, 40};
// Greys from one point to this many.
constexpr double kDarkest_points = 300.0;

using Box = Eigen::AlignedBox2d;

struct Canvas {
  Box box;
  double pixel_m = kFinest_m;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint32_t> standing;
  std::vector<bool> is_removed;

  [[nodiscard]] std::size_t pixel_of(const Eigen::Vector3d& point_m) const {
    const Eigen::Vector2d at = (point_m.head<2>() - box.min()) / pixel_m;
    const auto column = std::min(static_cast<std::uint32_t>(at.x()), width - 1);
    const auto row = std::min(static_cast<std::uint32_t>(at.y()), height - 1);
    return static_cast<std::size_t>(height - 1 - row) * width + column;
  }
};

Result<Box> box_of(const SurfacePointReader& reader) {
  Box box;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> points_m, reader.standing(part));
    for (const Eigen::Vector3d& point_m : points_m) box.extend(point_m.head<2>());
  }
  if (!box.isEmpty()) return box;
  return Error{ErrorCode::kBadArgument, "no points to draw"};
}

Canvas canvas_for(const Box& box) {
  Canvas canvas;
  canvas.box = box;
  canvas.pixel_m = std::max(kFinest_m, box.sizes().maxCoeff() / kMost_pixels);
  canvas.width = static_cast<std::uint32_t>(box.sizes().x() / canvas.pixel_m) + 1;
  canvas.height = static_cast<std::uint32_t>(box.sizes().y() / canvas.pixel_m) + 1;
  canvas.standing.assign(static_cast<std::size_t>(canvas.width) * canvas.height, 0);
  canvas.is_removed.assign(canvas.standing.size(), false);
  return canvas;
}

Colour grey_of(std::uint32_t count) {
  const double share = std::min(1.0, std::log1p(count) / std::log1p(kDarkest_points));
  const auto level = static_cast<std::uint8_t>(std::lround(225.0 - 150.0 * share));
  return {level, level, level};
}

// The points from above, north up, one pixel for each 0.2 m and coarser where the picture would be
// wider than 4000 pixels: the more that stands in a pixel the darker its grey; red where something
// was removed.
Result<Raster> points_picture(const SurfacePoints& points) {
  const SurfacePointReader reader(points);
  SIGHTLINE_ASSIGN(const Box box, box_of(reader));
  Canvas canvas = canvas_for(box);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    SIGHTLINE_ASSIGN(const std::vector<Eigen::Vector3d> points_m, reader.standing(part));
    for (const Eigen::Vector3d& point_m : points_m) ++canvas.standing[canvas.pixel_of(point_m)];
  }
  for (const CellKey& key : points.moved_voxels) {
    const Eigen::Vector3d centre_m = cell_centre_m(key, points.voxel_m);
    if (box.contains(centre_m.head<2>())) canvas.is_removed[canvas.pixel_of(centre_m)] = true;
  }
  Raster raster(canvas.width, canvas.height, kPaper);
  for (std::size_t i = 0; i < raster.pixels.size(); ++i) {
    if (canvas.standing[i] > 0) raster.pixels[i] = grey_of(canvas.standing[i]);
    if (canvas.is_removed[i]) raster.pixels[i] = kRemoved;
  }
  return raster;
}

Error bad(std::string message) { return {ErrorCode::kBadArgument, std::move(message)}; }

Result<std::string> png_text(const Raster& raster) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> file, encode_png(raster));
  return std::string(reinterpret_cast<const char*>(file.data()), file.size());
}

Result<std::string> draw_depth(const PictureRequest& request, const DepthImages& depth) {
  if (request.format != PictureFormat::kPng) return bad("--format: a depth image is drawn as png");
  if (request.site < 0 || static_cast<std::uint32_t>(request.site) >= depth.site_count) {
    return bad(concat("--site: a depth image needs one of 0 to ",
                      static_cast<std::int64_t>(depth.site_count) - 1));
  }
  return png_text(depth_picture(depth, static_cast<std::size_t>(request.site)));
}

Result<void> check_extent(const MapBox& box) {
  if (box.high_x_m > box.low_x_m && box.high_y_m > box.low_y_m) return {};
  return bad("--box: the second corner must be to the right of the first and above it");
}

Result<std::string> draw_nds(const PictureRequest& request, const NdtMap& ndt, const Sites& sites) {
  const MapBox box = request.box ? *request.box : box_around(ndt);
  SIGHTLINE_TRY(check_extent(box));
  if (request.format == PictureFormat::kSvg) return ndt_picture_svg(ndt, sites, box);
  return png_text(ndt_picture(ndt, sites, box));
}

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

Colour colour_of_distance(double distance_m, double longest_m) {
  if (std::isnan(distance_m)) return kPaper;
  return std::isfinite(distance_m) ? colour_on(kScale, distance_m / longest_m) : kNothing;
}

std::size_t seen_cell(const DepthImages& images, std::uint32_t column, std::uint32_t row) {
  const std::uint32_t azimuth =
      (images.azimuth_count / 2 + images.azimuth_count - 1 - column) % images.azimuth_count;
  return static_cast<std::size_t>(images.elevation_count - 1 - row) * images.azimuth_count +
         azimuth;
}

Raster depth_picture(const DepthImages& images, std::size_t site) {
  const std::uint32_t image_height = kPixelsPerCell * images.elevation_count;
  Raster raster(kPixelsPerCell * images.azimuth_count, image_height + kScaleGap + kScaleHeight,
                kPaper);
  for (std::uint32_t row = 0; row < image_height; ++row) {
    for (std::uint32_t column = 0; column < raster.width; ++column) {
      const std::size_t cell = seen_cell(images, column / kPixelsPerCell, row / kPixelsPerCell);
      raster.at(column, row) = colour_of_distance(static_cast<double>(images.image_of(site)[cell]),
                                                  images.longest_range_m);
    }
  }
  draw_scale(images.longest_range_m, image_height + kScaleGap, raster);
  return raster;
}

Result<MapBox> parse_box(const std::string& text) {
  MapBox box;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &box.low_x_m, &box.low_y_m, &box.high_x_m,
                  &box.high_y_m, &rest) != 4) {
    return bad(concat("--box: found \"", text, "\", expected x0,y0,x1,y1 in m"));
  }
  return box;
}

Result<std::string> draw_picture(const PictureRequest& request, const PictureSources& sources) {
  if (request.what == "depth" && sources.depth) return draw_depth(request, *sources.depth);
  if (request.what == "nds" && sources.ndt) return draw_nds(request, *sources.ndt, sources.sites);
  if (request.what == "points" && sources.points) return draw_points(request, *sources.points);
  if (request.what == "ranges" && sources.ranges) return draw_ranges(request, sources);
  return bad(
      concat("--format: svg and png are for depth and points (of a configuration), nds and ranges, "
             "not for \"",
             request.what, "\" here"));
}

}  // namespace sightline
