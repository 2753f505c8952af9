#include <cmath>

#include "compiler/views/report/page/json_numbers.h"
#include "compiler/views/report/page/page_data.h"

namespace sightline {
namespace {

constexpr std::size_t kMostNds = 200'000;  // drawn on the page's map

// A range in whole decimetres.
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
      before.push_back(has_answer ? decimetres(each.answers[limit].range_before_m) : 0);
      after.push_back(has_answer ? decimetres(each.answers[limit].range_after_m) : 0);
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

}  // namespace

PageJson diff_json(const MapDiff& diff, const MapFrame& frame) {
  return {
      {"limits_m", common_limits_m(diff)}, {"sites", sites_of(diff)}, {"nds", nds_of(diff, frame)}};
}

}  // namespace sightline
