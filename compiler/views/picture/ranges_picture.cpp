#include "compiler/views/picture/ranges_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "compiler/views/picture/ndt_picture.h"
#include "compiler/views/picture/raster.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

constexpr double kMargin_m = 40.0;
constexpr std::size_t kLimit = 0;  // limits ascend: the tightest
constexpr double kNdWidth_m = 0.7;
constexpr double kWidth_px = 1000.0;

// Lengths that follow the size of the picture.
struct Sizes {
  double font_m = 0.0;
  double route_m = 0.0;
  double legend_m = 0.0;  // height of the band below the map
};

Sizes sizes_of(const MapBox& box) {
  const double font_m = box.width_m() / 55.0;
  return {font_m, std::max(box.width_m(), box.height_m()) / 110.0, 4.0 * font_m};
}

// One ND of each column of cells, that of the most points: those above and below it hide behind it.
std::vector<const Nd*> standing_nds(const NdtMap& map, const MapBox& box) {
  std::map<std::pair<std::int64_t, std::int64_t>, const Nd*> columns;
  for (const Nd& nd : map.nds) {
    if (!box.contains(nd.mean_m) || is_lying_plane(nd)) continue;
    const Nd*& kept = columns[{nd.key.x, nd.key.y}];
    if (kept == nullptr || nd.point_count > kept->point_count) kept = &nd;
  }
  std::vector<const Nd*> nds;
  for (const auto& [column, nd] : columns) nds.push_back(nd);
  return nds;
}

// Decimetres are enough for the background, and keep the file small.
std::string nd_path(const NdtMap& map, const MapBox& box) {
  std::string path;
  for (const Nd* nd : standing_nds(map, box)) {
    const NdEllipse ellipse = ellipse_from_above(*nd);
    const Eigen::Vector2d along_m = 2.0 * ellipse.long_radius_m * ellipse.long_axis;
    const Eigen::Vector2d begin_m = ellipse.centre_m - 0.5 * along_m;
    path += fmt::format("M{:.1f} {:.1f}l{:.1f} {:.1f}", begin_m.x(), -begin_m.y(), along_m.x(),
                        -along_m.y());
  }
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"#a4a9b0\" stroke-linecap=\"round\" "
      "stroke-width=\"{:.1f}\"/>\n",
      path, kNdWidth_m);
}

// The ranges that the route takes at the limit, as indices into ranges_m. Colours are spread over
// these alone, so that neighbours can be distinguished.
struct Scale {
  std::size_t first = 0;
  std::size_t last = 0;

  [[nodiscard]] std::string colour(std::size_t range) const {
    return colour_name(range_colour_on_paper(range - first, last - first + 1));
  }
};

Scale scale_of(const RangeTable& ranges) {
  if (ranges.site_count == 0) return {};
  Scale scale{ranges.looks.size(), 0};
  for (std::size_t i = kLimit; i < ranges.range_index.size(); i += ranges.promises.size()) {
    scale.first = std::min(scale.first, std::size_t{ranges.range_index[i]});
    scale.last = std::max(scale.last, std::size_t{ranges.range_index[i]});
  }
  return scale;
}

bool is_unmet(const RangeTable& ranges, std::size_t site) {
  return (ranges.flags[site * ranges.promises.size() + kLimit] & kUnmet) != 0;
}

std::string dot(double x_m, double y_m, double radius_m) {
  return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\"/>\n", x_m, y_m, radius_m);
}

std::string unmet_dots(const Sites& sites, const RangeTable& ranges, double radius_m) {
  std::string svg;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Eigen::Vector3d& p_m = sites.sites[i].p_map_m;
    if (is_unmet(ranges, i)) svg += dot(p_m.x(), -p_m.y(), radius_m);
  }
  return svg;
}

std::string text_at(double x_m, double y_m, const std::string& text) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n", x_m, y_m, text);
}

// Two lines below the map: what the colours mean, then a swatch for each range.
std::string legend(const RangeTable& ranges, const MapBox& box, const Scale& scale,
                   bool has_unmet) {
  const double font_m = sizes_of(box).font_m;
  double x_m = box.low_x_m + 1.5 * font_m;
  double y_m = -box.low_y_m + 1.3 * font_m;
  std::string svg = fmt::format("<g font-size=\"{:.2f}\" fill=\"#222\">\n", font_m);
  svg += text_at(x_m, y_m,
                 fmt::format("Observation range (m) for a localization error within {:g} cm",
                             100.0 * ranges.promises[kLimit].limit_m));
  y_m += 1.6 * font_m;
  for (std::size_t i = scale.first; i <= scale.last; ++i) {
    svg += fmt::format(
               "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n",
               x_m, y_m - 0.75 * font_m, 1.6 * font_m, 0.8 * font_m, scale.colour(i)) +
           text_at(x_m + 1.9 * font_m, y_m, fixed(ranges.looks[i].range_m, 0));
    x_m += 3.7 * font_m;
  }
  if (has_unmet) {
    svg += dot(x_m + 0.5 * font_m, y_m - 0.35 * font_m, 0.25 * font_m) +
           text_at(x_m + 1.2 * font_m, y_m, "no range is good enough");
  }
  return svg + "</g>\n";
}

// 1, 2 or 5 times a power of ten.
double round_length_m(double most_m) {
  const double power_m = std::pow(10.0, std::floor(std::log10(most_m)));
  if (most_m >= 5.0 * power_m) return 5.0 * power_m;
  return most_m >= 2.0 * power_m ? 2.0 * power_m : power_m;
}

}  // namespace

MapBox ranges_picture_box(const Sites& sites) { return box_of_route(sites, kMargin_m); }

std::string ranges_picture_svg(const NdtMap& map, const Sites& sites, const RangeTable& ranges,
                               const MapBox& box) {
  const Sizes sizes = sizes_of(box);
  const double height_m = box.height_m() + sizes.legend_m;
  bool has_unmet = false;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) has_unmet |= is_unmet(ranges, i);
  const Scale scale = scale_of(ranges);
  const auto colour_of = [&](std::size_t range) { return scale.colour(range); };
  return concat(
      fmt::format(
          "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{0:.2f} {1:.2f} {2:.2f} "
          "{3:.2f}\" width=\"{4:.0f}\" height=\"{5:.0f}\" font-family=\"sans-serif\">\n<rect "
          "x=\"{0:.2f}\" y=\"{1:.2f}\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
          box.low_x_m, -box.high_y_m, box.width_m(), height_m, kWidth_px,
          kWidth_px * height_m / box.width_m()),
      nd_path(map, box), route_svg(sites, ranges, kLimit, sizes.route_m, colour_of),
      unmet_dots(sites, ranges, 0.25 * sizes.route_m), scale_bar_svg(box, "#222"),
      legend(ranges, box, scale, has_unmet), "</svg>\n");
}

MapBox box_of_route(const Sites& sites, double margin_m) {
  Eigen::AlignedBox2d around;
  for (const Site& site : sites.sites) around.extend(site.p_map_m.head<2>());
  if (around.isEmpty()) return {};
  return {around.min().x() - margin_m, around.min().y() - margin_m, around.max().x() + margin_m,
          around.max().y() + margin_m};
}

std::string route_svg(const Sites& sites, const RangeTable& ranges, std::size_t limit,
                      double width_m, const std::function<std::string(std::size_t)>& colour_of) {
  const auto range_of = [&](std::size_t site) { return ranges.range(site, limit); };
  std::string svg;
  std::string path;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const Eigen::Vector3d& p_m = sites.sites[i].p_map_m;
    const std::string place = fmt::format("{:.2f} {:.2f}", p_m.x(), -p_m.y());
    path += (path.empty() ? "M" : "L") + place;
    const bool goes_on = i + 1 < sites.sites.size() && sites.sites[i + 1].run == sites.sites[i].run;
    if (goes_on && range_of(i + 1) == range_of(i)) continue;
    svg += fmt::format(
        "<path d=\"{}h.01\" "
        "style=\"fill:none;stroke-linecap:round;stroke-width:{:.2f};stroke:{}\"/>\n",
        path, width_m, colour_of(range_of(i)));
    // The next stretch of a run begins where this one ends.
    path = goes_on ? "M" + place : "";
  }
  return svg;
}

std::string scale_bar_svg(const MapBox& box, const std::string& colour) {
  const double width_m = box.width_m();
  const double length_m = round_length_m(width_m / 4.0);
  const double y_m = -box.low_y_m - 0.03 * width_m;
  return fmt::format(
      R"(<path d="M{0:.2f} {1:.2f}h{2:.2f}" style="stroke:{3};stroke-width:{4:.2f}"/>)"
      "<text x=\"{0:.2f}\" y=\"{5:.2f}\" font-size=\"{6:.2f}\" fill=\"{3}\">{2:.{7}f} m</text>\n",
      box.low_x_m + 0.03 * width_m, y_m, length_m, colour, width_m / 250.0, y_m - 0.012 * width_m,
      width_m / 55.0, length_m < 1.0 ? 2 : 0);
}

}  // namespace sightline
