#include <algorithm>
#include <cmath>

#include "compiler/views/report/page/json_numbers.h"
#include "compiler/views/report/page/page_data.h"
#include "compiler/views/report/page/route.h"
#include "compiler/views/text/describe_site.h"

namespace sightline {
namespace {

constexpr std::size_t kSitesPerBlock = 64;

std::vector<float> as_floats(const std::vector<double>& values) {
  return {values.begin(), values.end()};
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
  return {
      {"count", map.sites.sites.size()}, {"x_m", json_numbers(x_m)},
      {"y_m", json_numbers(y_m)},        {"z_m", json_numbers(z_m)},
      {"s_m", json_numbers(s_m)},        {"heading_rad", json_numbers(heading_rad)},
      {"run", json_numbers(run)},        {"route_m", json_numbers(route_of_sites_m(map.sites))}};
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
  return {{"names", map.factors.factors},
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

}  // namespace sightline
