#include "compiler/report/page_data.h"

#include "compiler/report/json_text.h"
#include "formats/quoted_text.h"

namespace sightline {

std::string page_data_json(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  std::vector<double> limits_m, thresholds;
  for (const LimitPromise& promise : map.ranges.promises) {
    limits_m.push_back(promise.limit_m);
    thresholds.push_back(promise.probability_threshold);
  }
  std::vector<JsonMember> members = {
      {"ranges_m", json_array(map.ranges.ranges_m)},
      {"limits_m", json_array(limits_m)},
      {"site_spacing_m", format_double(map.sites.spacing_m)},
      {"selection", json_string(selection_name(map.ranges.selection))},
      {"dilation_m", format_double(map.ranges.dilation_m)},
      {"thresholds", json_array(thresholds)},
      {"sites", sites_json(map)},
      {"predicted", predicted_json(map)},
      {"choice", choice_json(map)}};
  if (sources.evaluation) members.emplace_back("judged", judged_json(*sources.evaluation));
  if (!map.factors.factors.empty()) members.emplace_back("factors", factors_json(map));
  members.emplace_back("texts", texts_json(map));
  if (sources.depth) members.emplace_back("depth", depth_json(*sources.depth));
  members.emplace_back("nds", nds_json(map.ndt));
  if (sources.surface) {
    members.emplace_back("relief", relief_json(*sources.surface, map.sites, map.sensor.height_m));
  }
  if (sources.points && sources.points->voxel_m > 0.0) {
    members.emplace_back("moved", moved_json(*sources.points, map.ndt.tile_m));
  }
  if (sources.diff) members.emplace_back("diff", diff_json(*sources.diff, map.ndt.frame));
  return json_object(members);
}

}  // namespace sightline
