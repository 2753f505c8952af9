#include "compiler/views/report/page/page_data.h"

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

PageJson json_of(const Eigen::Vector3d& p_m) {
  return PageJson::array({p_m.x(), p_m.y(), p_m.z()});
}

// JSON that may stand in a page: "<" could end the script that it is in. Names need not be UTF-8.
std::string page_text(const PageJson& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, PageJson::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

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
                   {"choice", choice_json(map)}};
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
