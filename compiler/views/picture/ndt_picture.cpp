#include "compiler/views/picture/ndt_picture.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "compiler/views/picture/raster.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

constexpr double kSiteRadius_m = 0.3;
constexpr double kLongerSide_px = 1200.0;
constexpr Colour kPaper = {255, 255, 255};
constexpr Colour kLine = {230, 130, 20};
constexpr Colour kStandingPlane = {30, 90, 200};
constexpr Colour kLyingPlane = {205, 205, 205};
constexpr Colour kVolume = {60, 160, 70};
constexpr Colour kSite = {0, 0, 0};

struct Shape {
  NdEllipse ellipse;
  double height_m = 0.0;
  Colour colour;
};

Colour colour_of(const Nd& nd) {
  const int dimension = dimension_class(nd);
  if (dimension == 1) return kLine;
  if (dimension == 3) return kVolume;
  return is_lying_plane(nd) ? kLyingPlane : kStandingPlane;
}

// From below to above, the ground first.
std::vector<Shape> shapes_in(const NdtMap& map, const MapBox& box) {
  std::vector<Shape> shapes;
  for (const Nd& nd : map.nds) {
    if (!box.contains(nd.mean_m)) continue;
    shapes.push_back({ellipse_from_above(nd), nd.mean_m.z(), colour_of(nd)});
  }
  std::stable_sort(shapes.begin(), shapes.end(), [](const Shape& a, const Shape& b) {
    const bool a_lies = a.colour == kLyingPlane;
    const bool b_lies = b.colour == kLyingPlane;
    return a_lies != b_lies ? a_lies : a.height_m < b.height_m;
  });
  return shapes;
}

// Map coordinates to pixels.
class Canvas {
 public:
  Canvas(const MapBox& box, double px_per_m) : box_(box), px_per_m_(px_per_m) {}

  void fill(const Shape& shape, Raster& raster) const {
    const NdEllipse& ellipse = shape.ellipse;
    const double reach_m = ellipse.long_radius_m;
    const auto [first_column, last_column] =
        span_of(ellipse.centre_m.x() - box_.low_x_m - reach_m, reach_m, raster.width);
    const auto [first_row, last_row] =
        span_of(box_.high_y_m - ellipse.centre_m.y() - reach_m, reach_m, raster.height);
    for (std::uint32_t row = first_row; row < last_row; ++row) {
      for (std::uint32_t column = first_column; column < last_column; ++column) {
        const Eigen::Vector2d at_m(box_.low_x_m + (column + 0.5) / px_per_m_,
                                   box_.high_y_m - (row + 0.5) / px_per_m_);
        if (contains(ellipse, at_m)) raster.at(column, row) = shape.colour;
      }
    }
  }

 private:
  // Pixels from begin_m to begin_m + 2 reach_m that are on the raster.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> span_of(double begin_m, double reach_m,
                                                                std::uint32_t size) const {
    const double last = static_cast<double>(size);
    const double from = std::clamp(std::floor(begin_m * px_per_m_), 0.0, last);
    const double to = std::clamp(std::ceil((begin_m + 2.0 * reach_m) * px_per_m_), 0.0, last);
    return {static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to)};
  }

  // Never thinner than a pixel.
  [[nodiscard]] bool contains(const NdEllipse& ellipse, const Eigen::Vector2d& at_m) const {
    const Eigen::Vector2d off_m = at_m - ellipse.centre_m;
    const double along_m = off_m.dot(ellipse.long_axis);
    const double across_m = off_m.x() * -ellipse.long_axis.y() + off_m.y() * ellipse.long_axis.x();
    const double least_m = 0.75 / px_per_m_;
    const double u = along_m / std::max(ellipse.long_radius_m, least_m);
    const double v = across_m / std::max(ellipse.short_radius_m, least_m);
    return u * u + v * v <= 1.0;
  }

  MapBox box_;
  double px_per_m_;
};

Shape dot_of(const Site& site) {
  Shape dot;
  dot.ellipse.centre_m = site.p_map_m.head<2>();
  dot.ellipse.long_radius_m = dot.ellipse.short_radius_m = kSiteRadius_m;
  dot.colour = kSite;
  return dot;
}

constexpr double kSigmas = 2.0;
constexpr double kLeastRadius_m = 0.05;

}  // namespace

MapBox box_around(const NdtMap& map) {
  if (map.nds.empty()) return {};
  Eigen::Vector3d low_m = map.nds[0].mean_m;
  Eigen::Vector3d high_m = low_m;
  for (const Nd& nd : map.nds) {
    low_m = low_m.cwiseMin(nd.mean_m);
    high_m = high_m.cwiseMax(nd.mean_m);
  }
  return {low_m.x(), low_m.y(), high_m.x(), high_m.y()};
}

std::string ndt_picture_svg(const NdtMap& map, const Sites& sites, const MapBox& box) {
  // y grows downwards in SVG: everything is drawn at -y.
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{:.3f} {:.3f} {:.3f} {:.3f}\">\n<rect "
      "x=\"{:.3f}\" y=\"{:.3f}\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      box.low_x_m, -box.high_y_m, box.width_m(), box.height_m(), box.low_x_m, -box.high_y_m);
  for (const Shape& shape : shapes_in(map, box)) {
    const NdEllipse& ellipse = shape.ellipse;
    const double turn_deg =
        -std::atan2(ellipse.long_axis.y(), ellipse.long_axis.x()) * 180.0 / std::numbers::pi;
    text += fmt::format(
        "<ellipse transform=\"translate({:.3f} {:.3f}) rotate({:.2f})\" rx=\"{:.3f}\" "
        "ry=\"{:.3f}\" fill=\"{}\"/>\n",
        ellipse.centre_m.x(), -ellipse.centre_m.y(), turn_deg, ellipse.long_radius_m,
        ellipse.short_radius_m, colour_name(shape.colour));
  }
  for (const Site& site : sites.sites) {
    if (!box.contains(site.p_map_m)) continue;
    text += fmt::format("<circle cx=\"{:.3f}\" cy=\"{:.3f}\" r=\"{:.2f}\"/>\n", site.p_map_m.x(),
                        -site.p_map_m.y(), kSiteRadius_m);
  }
  return text + "</svg>\n";
}

Raster ndt_picture(const NdtMap& map, const Sites& sites, const MapBox& box) {
  const double px_per_m = kLongerSide_px / std::max(box.width_m(), box.height_m());
  Raster raster(static_cast<std::uint32_t>(std::ceil(box.width_m() * px_per_m)),
                static_cast<std::uint32_t>(std::ceil(box.height_m() * px_per_m)), kPaper);
  const Canvas canvas(box, px_per_m);
  for (const Shape& shape : shapes_in(map, box)) canvas.fill(shape, raster);
  for (const Site& site : sites.sites) {
    if (box.contains(site.p_map_m)) canvas.fill(dot_of(site), raster);
  }
  return raster;
}

NdEllipse ellipse_from_above(const Nd& nd) {
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(nd.covariance_m2.topLeftCorner<2, 2>());
  const auto radius_m = [&](int i) {
    return std::max(kLeastRadius_m, kSigmas * std::sqrt(std::max(0.0, eigen.values[i])));
  };
  NdEllipse ellipse;
  ellipse.centre_m = nd.mean_m.head<2>();
  ellipse.long_axis = eigen.vectors.col(1);
  ellipse.long_radius_m = radius_m(1);
  ellipse.short_radius_m = radius_m(0);
  return ellipse;
}

bool is_lying_plane(const Nd& nd) {
  return dimension_class(nd) == 2 && std::abs(nd.eigenvectors(2, 2)) > std::numbers::sqrt2 / 2.0;
}

}  // namespace sightline
