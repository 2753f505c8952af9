#include "compiler/views/report/page/page_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "compiler/views/picture/ndt_picture.h"
#include "compiler/views/report/page/packed.h"
#include "compiler/views/report/page/page_answers.h"
#include "compiler/views/report/page/pictures.h"
#include "compiler/views/text/describe_site.h"
#include "compiler/views/text/factor_words.h"
#include "compiler/views/verdict/verdict.h"
#include "formats/base/printable.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

PageJson json_of(const Eigen::Vector3d& p_m) {
  return PageJson::array({p_m.x(), p_m.y(), p_m.z()});
}

// JSON that may stand in a page: "<" could end the script that it is in. Names need not be UTF-8.
std::string page_text(const PageJson& json) {
  std::string text;
  for (const char c :
       printable_json(json.dump(-1, ' ', false, PageJson::error_handler_t::replace))) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

constexpr std::size_t kSitesPerBlock = 64;

std::vector<float> as_floats(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

// Of the column "unconstrained"; empty in a map whose poses all are constrained.
std::vector<std::uint8_t> unconstrained_of(const CompiledMap& map) {
  std::vector<std::uint8_t> directions;
  const auto column = std::ranges::find(map.columns, "unconstrained", &SiteColumn::name);
  if (column == map.columns.end()) return directions;
  for (const float value : column->values) {
    directions.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F)));
  }
  return directions;
}

PageJson sites_json(const CompiledMap& map) {
  std::vector<double> x_m, y_m, z_m, s_m, heading_rad;
  std::vector<std::uint32_t> run;
  for (const Site& site : map.sites.sites) {
    const Eigen::Vector3d ahead = site.T_map_vehicle.linear().col(0);
    x_m.push_back(site.p_map_m.x());
    y_m.push_back(site.p_map_m.y());
    z_m.push_back(site.p_map_m.z());
    s_m.push_back(site.s_m);
    heading_rad.push_back(std::atan2(ahead.y(), ahead.x()));
    run.push_back(site.run);
  }
  PageJson json = {
      {"count", map.sites.sites.size()}, {"x_m", json_numbers(x_m)},
      {"y_m", json_numbers(y_m)},        {"z_m", json_numbers(z_m)},
      {"s_m", json_numbers(s_m)},        {"heading_rad", json_numbers(heading_rad)},
      {"run", json_numbers(run)},        {"route_m", json_numbers(route_of_sites_m(map.sites))}};
  const std::vector<std::uint8_t> unconstrained = unconstrained_of(map);
  if (!unconstrained.empty()) json["unconstrained"] = json_numbers(unconstrained);
  return json;
}

PageJson predicted_json(const CompiledMap& map) {
  return {{"mean_m", json_numbers(as_floats(map.predicted.mean_m))},
          {"probability", json_numbers(as_floats(map.predicted.within_probability))},
          {"extrapolated", json_numbers(map.predicted.extrapolated)}};
}

PageJson choice_json(const CompiledMap& map) {
  return {{"range_index", json_numbers(map.ranges.range_index)},
          {"flags", json_numbers(map.ranges.flags)}};
}

PageJson judged_json(const Evaluation& evaluation) {
  std::vector<std::string_view> rules;
  for (std::size_t rule = 0; rule < kRuleCount; ++rule) {
    rules.push_back(name_of(static_cast<Rule>(rule)));
  }
  std::vector<std::uint32_t> sites;
  for (const JudgedSite& site : evaluation.sites) sites.push_back(site.site);
  return {{"drive", evaluation.drive},
          {"rules", rules},
          {"site", json_numbers(sites)},
          {"error_m", json_numbers(as_floats(evaluation.error_m))},
          {"time_ms", json_numbers(as_floats(evaluation.time_ms))},
          {"chosen", json_numbers(evaluation.chosen_range_index)}};
}

PageJson factors_json(const CompiledMap& map) {
  std::vector<float> values;
  values.reserve(map.factors.values.size());
  for (const double value : map.factors.values) values.push_back(four_digits(value));
  const RouteFactors route = route_factors(map.factors);
  std::vector<std::string> words;
  for (const std::string& name : map.factors.factors) words.push_back(factor_words(name));
  return {{"names", map.factors.factors},
          {"words", words},
          {"values", json_numbers(values)},
          {"median", json_numbers(route.median)},
          {"deviation", json_numbers(route.deviation)}};
}

PageJson texts_json(const CompiledMap& map) {
  const RouteFactors route = route_factors(map.factors);
  std::vector<std::string> blocks;
  for (std::size_t begin = 0; begin < map.sites.sites.size(); begin += kSitesPerBlock) {
    std::string block;
    const std::size_t end = std::min(begin + kSitesPerBlock, map.sites.sites.size());
    for (std::size_t site = begin; site < end; ++site) {
      const Result<std::string> text = describe_site(map, route, site);
      SIGHTLINE_CHECK(text.has_value());
      block += *text + '\0';
    }
    blocks.push_back(packed(block));
  }
  return {{"sites_per_block", kSitesPerBlock}, {"blocks", blocks}};
}

constexpr double kSigmas = 2.0;
constexpr double kMillimetre = 0.001;
constexpr double kCentimetre = 0.01;
constexpr std::uint8_t kLyingPlane = 4;  // a kind beside the dimension classes

double lowest_z_m(const NdtMap& map) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Nd& nd : map.nds) lowest = std::min(lowest, nd.mean_m.z());
  return map.nds.empty() ? 0.0 : lowest;
}

std::uint16_t steps_of(double value, double step) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(value / step), 0L, 65535L));
}

// NDs of one tile, column by column.
struct NdColumns {
  std::vector<std::uint16_t> place, height, radius, rise;
  std::vector<std::uint8_t> turn, tilt, kind;
};

constexpr double kTurnStep_rad = std::numbers::pi / 256.0;

// The longer axis from above: its turn from +x in steps, and its direction, of which the turn is
// the nearest step.
std::pair<std::uint8_t, Eigen::Vector2d> long_axis(const SymmetricEigen<2>& eigen) {
  const Eigen::Vector2d along = eigen.vectors.col(1);
  const long steps = std::lround(std::atan2(along.y(), along.x()) / kTurnStep_rad) & 511L;
  const bool is_opposite = steps >= 256;  // half a turn more
  return {static_cast<std::uint8_t>(steps & 255L), is_opposite ? Eigen::Vector2d(-along) : along};
}

// The correlation of height with place along a direction from above, in steps: 127 is none.
std::uint8_t tilt_of(const Nd& nd, const Eigen::Vector2d& along, double variance_m2) {
  constexpr double kSteps = 127.0;  // of a correlation of 1
  const double both_m2 = std::sqrt(std::max(0.0, variance_m2 * nd.covariance_m2(2, 2)));
  const double shared_m2 = along.dot(nd.covariance_m2.block<2, 1>(0, 2));
  const double correlation = both_m2 > 0.0 ? std::clamp(shared_m2 / both_m2, -1.0, 1.0) : 0.0;
  return static_cast<std::uint8_t>(std::lround(kSteps * (1.0 + correlation)));
}

void append(const Nd& nd, const Eigen::Vector3d& corner_m, double tile_m, NdColumns& columns) {
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(nd.covariance_m2.topLeftCorner<2, 2>());
  const auto radius_m = [&](int i) { return kSigmas * std::sqrt(std::max(0.0, eigen.values[i])); };
  const Eigen::Vector3d off_m = nd.mean_m - corner_m;
  columns.place.push_back(steps_of(off_m.x(), tile_m / 65535.0));
  columns.place.push_back(steps_of(off_m.y(), tile_m / 65535.0));
  columns.height.push_back(steps_of(off_m.z(), kCentimetre));
  columns.radius.push_back(steps_of(radius_m(1), kMillimetre));
  columns.radius.push_back(steps_of(radius_m(0), kMillimetre));
  const auto [turn, along] = long_axis(eigen);
  columns.turn.push_back(turn);
  columns.rise.push_back(
      steps_of(kSigmas * std::sqrt(std::max(0.0, nd.covariance_m2(2, 2))), kMillimetre));
  columns.tilt.push_back(tilt_of(nd, along, eigen.values[1]));
  columns.tilt.push_back(tilt_of(nd, {-along.y(), along.x()}, eigen.values[0]));
  columns.kind.push_back(is_lying_plane(nd) ? kLyingPlane
                                            : static_cast<std::uint8_t>(dimension_class(nd)));
}

PageJson nds_json(const NdtMap& map) {
  const double lowest_m = lowest_z_m(map);
  PageJson tiles = PageJson::array();
  for (std::size_t begin = 0; begin < map.nds.size();) {
    const TileKey key = tile_of(map.nds[begin].key, map.cell_m, map.tile_m);
    const Eigen::Vector3d corner_m(key.x * map.tile_m, key.y * map.tile_m, lowest_m);
    NdColumns columns;
    std::size_t end = begin;
    for (; end < map.nds.size() && tile_of(map.nds[end].key, map.cell_m, map.tile_m) == key;
         ++end) {
      append(map.nds[end], corner_m, map.tile_m, columns);
    }
    tiles.push_back({{"x", key.x},
                     {"y", key.y},
                     {"count", end - begin},
                     {"place_m", json_numbers(columns.place)},
                     {"height", json_numbers(columns.height)},
                     {"radius", json_numbers(columns.radius)},
                     {"turn", json_numbers(columns.turn)},
                     {"rise", json_numbers(columns.rise)},
                     {"tilt", json_numbers(columns.tilt)},
                     {"kind", json_numbers(columns.kind)}});
    begin = end;
  }
  return {
      {"cell_m", map.cell_m}, {"tile_m", map.tile_m}, {"lowest_z_m", lowest_m}, {"tiles", tiles}};
}

constexpr std::size_t kMostNds = 200'000;  // drawn on the page's map

std::uint16_t decimetres(double range_m) {
  return static_cast<std::uint16_t>(std::lround(10.0 * range_m));
}

PageJson sites_of(const MapDiff& diff) {
  std::vector<std::uint32_t> site;
  std::vector<std::uint16_t> before, after;
  std::vector<std::uint8_t> change;
  for (const SiteDiff& each : diff.sites) {
    if (each.change == SiteChange::kRemoved) continue;  // no site of this map
    site.push_back(each.site);
    change.push_back(static_cast<std::uint8_t>(each.change));
    for (std::size_t limit = 0; limit < common_limits_m(diff).size(); ++limit) {
      const bool has_answer = limit < each.answers.size();
      before.push_back(has_answer ? decimetres(each.answers[limit].before.range_m) : 0);
      after.push_back(has_answer ? decimetres(each.answers[limit].after.range_m) : 0);
    }
  }
  return {{"site", json_numbers(site)},
          {"change", json_numbers(change)},
          {"before_dm", json_numbers(before)},
          {"after_dm", json_numbers(after)}};
}

PageJson nds_of(const MapDiff& diff, const MapFrame& frame) {
  std::vector<float> x_m, y_m;
  std::vector<std::uint8_t> change;
  const std::size_t stride = diff.nds.size() / kMostNds + 1;
  for (std::size_t i = 0; i < diff.nds.size(); i += stride) {
    const Eigen::Vector3d mean_m = diff.nds[i].mean_world_m - frame.origin_world_m;
    x_m.push_back(static_cast<float>(mean_m.x()));
    y_m.push_back(static_cast<float>(mean_m.y()));
    change.push_back(static_cast<std::uint8_t>(diff.nds[i].change));
  }
  return {{"stride", stride},
          {"x_m", json_numbers(x_m)},
          {"y_m", json_numbers(y_m)},
          {"change", json_numbers(change)}};
}

PageJson diff_json(const MapDiff& diff, const MapFrame& frame) {
  return {
      {"limits_m", common_limits_m(diff)}, {"sites", sites_of(diff)}, {"nds", nds_of(diff, frame)}};
}

}  // namespace

std::vector<double> route_of_sites_m(const Sites& sites) {
  std::vector<double> route_m;
  double before_m = 0.0;  // of the runs before
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    const bool is_new_run = i > 0 && sites.sites[i].run != sites.sites[i - 1].run;
    if (is_new_run) before_m = route_m.back() + sites.spacing_m;
    route_m.push_back(before_m + sites.sites[i].s_m);
  }
  return route_m;
}

std::string page_data_json(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  std::vector<double> limits_m, thresholds;
  for (const LimitPromise& promise : map.ranges.promises) {
    limits_m.push_back(promise.limit_m);
    thresholds.push_back(promise.probability_threshold);
  }
  PageJson json = {{"ranges_m", ranges_of(map.ranges.looks)},
                   {"limits_m", limits_m},
                   {"origin_world_m", json_of(map.ndt.frame.origin_world_m)},
                   {"site_spacing_m", map.sites.spacing_m},
                   {"selection", name_of(map.ranges.selection)},
                   {"dilation_m", map.ranges.dilation_m},
                   {"thresholds", thresholds},
                   {"sites", sites_json(map)},
                   {"predicted", predicted_json(map)},
                   {"choice", choice_json(map)},
                   {"answers", answers_json(map, judge_map(map, sources.figures, {}))},
                   {"places", places_json(map)}};
  if (sources.evaluation) json["judged"] = judged_json(*sources.evaluation);
  if (!map.factors.factors.empty()) json["factors"] = factors_json(map);
  json["texts"] = texts_json(map);
  if (sources.depth) json["depth"] = depth_json(*sources.depth, map.sites.spacing_m);
  json["nds"] = nds_json(map.ndt);
  if (sources.surface) {
    json["relief"] = relief_json(*sources.surface, map.sites, map.sensor.height_m);
  }
  if (sources.points && sources.points->voxel_m > 0.0) {
    json["moved"] = moved_json(*sources.points, map.ndt.tile_m);
  }
  if (sources.diff) json["diff"] = diff_json(*sources.diff, map.ndt.frame);
  return page_text(json);
}

}  // namespace sightline
