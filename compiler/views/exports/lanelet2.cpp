#include "compiler/views/exports/lanelet2.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "compiler/views/exports/export_frame.h"
#include "compiler/views/exports/lane_answers.h"
#include "formats/foreign/lanes/osm_text.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

const std::vector<std::string_view> kOurKeys = {"observation_range_", "observation_look_",
                                                "observation_known", "observation_localizer"};

// Shares and metres for people: no more digits than say something.
std::string rounded(double value) { return format_double(std::round(value * 1000.0) / 1000.0); }

// Each figure of a look as a tag of its own; 0 is "all" and "not thinned", as in
// formats/drive/look.h.
void add_look(const std::string& key, const Look& look, OsmTags& tags) {
  tags.emplace_back(key + "_range", rounded(look.range_m));
  tags.emplace_back(key + "_returns", std::to_string(look.return_count));
  tags.emplace_back(key + "_points", std::to_string(look.point_count));
  tags.emplace_back(key + "_even_beyond", rounded(look.even_beyond_m));
  tags.emplace_back(key + "_by_normals", look.is_by_normals ? "yes" : "no");
  tags.emplace_back(key + "_settles", look.mode == LookMode::kSettle ? "yes" : "no");
}

OsmTags tags_of(const LaneAnswers& answers, const MapInfo& info) {
  OsmTags tags;
  for (std::size_t limit = 0; limit < answers.limits.size(); ++limit) {
    const LaneLimit& along = answers.limits[limit];
    const std::string range = "observation_range_" + limit_suffix(info.limits_m[limit]);
    const std::string look = "observation_look_" + limit_suffix(info.limits_m[limit]);
    if (along.ranges_m.empty()) {
      tags.emplace_back(range, "unknown");
      tags.emplace_back(look + "_range", "unknown");
      continue;
    }
    tags.emplace_back(range, rounded(along.ranges_m.back()));
    tags.emplace_back(range + "_p95", rounded(nearest_rank(along.ranges_m, 0.95)));
    tags.emplace_back(range + "_least", rounded(along.ranges_m.front()));
    tags.emplace_back(range + "_unmet", rounded(along.unmet_share));
    add_look(look, along.look, tags);
    tags.emplace_back(look + "_unmet", rounded(along.look_unmet_share));
  }
  tags.emplace_back("observation_known", rounded(answers.known_share));
  tags.emplace_back("observation_localizer", info.localizer);
  return tags;
}

// Cuts stretches out of lanelets.
class AreaMaker {
 public:
  AreaMaker(const LaneletMap& map, double limit_m, OsmAdditions& additions)
      : map_(map), limit_m_(limit_m), additions_(additions), next_id_(map.largest_id + 1) {}

  void add(const Lanelet& lanelet, const LaneStretch& stretch, const char* subtype) {
    OsmElement area;
    area.refs = cut(lanelet.left, stretch);
    const std::vector<std::string> right = cut(lanelet.right, stretch);
    area.refs.insert(area.refs.end(), right.rbegin(), right.rend());  // clockwise
    area.head = concat("way id=\"", next_id_++, "\"");
    area.tags = {{"type", "degenerate_area"},
                 {"subtype", subtype},
                 {"area", "yes"},
                 {"observation_limit_m", format_double(limit_m_)},
                 {"lanelet", lanelet.id}};
    additions_.ways.push_back(std::move(area));
  }

 private:
  // The nodes of a side from one share of its length to another; new ones at both ends where none
  // stands there.
  std::vector<std::string> cut(const LaneletSide& side, const LaneStretch& stretch) {
    const LineByShare line(side.points_m);
    const LineByShare::Place from = line.place(stretch.from);
    const LineByShare::Place to = line.place(stretch.to);
    std::vector<std::string> ids = {node_at(side, from)};
    for (std::size_t i = from.segment + 1; i <= to.segment; ++i) {
      ids.push_back(map_.nodes[side.nodes[i]].id);
    }
    ids.push_back(node_at(side, to));
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
  }

  std::string node_at(const LaneletSide& side, const LineByShare::Place& place) {
    const LaneletNode& before = map_.nodes[side.nodes[place.segment]];
    const LaneletNode& after = map_.nodes[side.nodes[place.segment + 1]];
    if (place.within == 0.0) return before.id;
    if (place.within == 1.0) return after.id;
    const auto between = [&](std::optional<double> LaneletNode::*field,
                             int decimals) -> std::optional<std::string> {
      if (!(before.*field) || !(after.*field)) return std::nullopt;
      return fixed(*(before.*field) + place.within * (*(after.*field) - *(before.*field)),
                   decimals);
    };
    const std::string id = std::to_string(next_id_++);
    OsmElement node;
    // Eleven decimals of a degree are a micrometre.
    node.head =
        concat("node id=\"", id, "\" lat=\"", between(&LaneletNode::latitude_deg, 11).value_or(""),
               "\" lon=\"", between(&LaneletNode::longitude_deg, 11).value_or(""), "\"");
    if (const auto x_m = between(&LaneletNode::local_x_m, 4))
      node.tags.emplace_back("local_x", *x_m);
    if (const auto y_m = between(&LaneletNode::local_y_m, 4))
      node.tags.emplace_back("local_y", *y_m);
    if (const auto z_m = between(&LaneletNode::height_m, 4)) node.tags.emplace_back("ele", *z_m);
    additions_.nodes.push_back(std::move(node));
    return id;
  }

  const LaneletMap& map_;
  double limit_m_;
  OsmAdditions& additions_;
  std::int64_t next_id_;
};

double distance_m(const LaneletMap& lanes, const LaneAsker& asker) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const Lanelet& lanelet : lanes.lanelets) {
    for (const Eigen::Vector3d& p_m : lanelet.left.points_m) {
      least_m = std::min(least_m, asker.distance_m(p_m));
    }
  }
  return least_m;
}

// Where local coordinates count from: squares of 100 km apart, so that no map lies in both.
Result<LaneletMap> lanes_of(const CompiledMap& map, const World& world, const std::string& text) {
  const auto read = [&](const Eigen::Vector2d& origin_m) {
    return read_lanelets({text, "", world, origin_m}, LaneletsRead::kAll);
  };
  SIGHTLINE_ASSIGN(LaneletMap lanes, read(Eigen::Vector2d::Zero()));
  const Eigen::Vector2d exported_m = export_origin_m(map.ndt.frame).head<2>();
  if (world.kind != WorldKind::kLocal || exported_m.isZero() || lanes.lanelets.empty())
    return lanes;
  const Eigen::Vector2d first_m = lanes.lanelets.front().left.points_m.front().head<2>();
  const Eigen::Vector2d away_m = first_m - map.ndt.frame.origin_world_m.head<2>();
  if (away_m.norm() <= (away_m + exported_m).norm()) return lanes;
  return read(exported_m);
}

Result<std::size_t> limit_of(const MapInfo& info, double limit_m) {
  if (limit_m == 0.0) return info.limits_m.size() - 1;
  const auto found = std::ranges::find(info.limits_m, limit_m);
  if (found != info.limits_m.end()) return static_cast<std::size_t>(found - info.limits_m.begin());
  std::string known;
  for (const double said_m : info.limits_m) known += " " + format_double(said_m);
  return Error{ErrorCode::kBadArgument,
               concat("--area-limit ", format_double(limit_m), ": the map has the limits", known)};
}

}  // namespace

std::string limit_suffix(double limit_m) {
  std::string digits = fixed(limit_m, 6);
  const std::size_t point = digits.find('.');
  while (digits.size() > point + 3 && digits.back() == '0') digits.pop_back();
  return digits.erase(point, 1);
}

Result<Lanelet2Export> to_lanelet2(const CompiledMap& map, const MapReader& reader,
                                   const World& world, const std::string& text,
                                   const Lanelet2Options& options) {
  const MapInfo& info = reader.info();
  SIGHTLINE_ASSIGN(const std::size_t area_limit, limit_of(info, options.area_limit_m));
  SIGHTLINE_ASSIGN(const std::string clean, without_additions(text, kOurKeys));
  SIGHTLINE_ASSIGN(const LaneletMap lanes, lanes_of(map, world, clean));
  if (lanes.lanelets.empty()) return Error{ErrorCode::kMissingField, "found no lanelet"};
  constexpr std::int64_t kLargestId = std::numeric_limits<std::int64_t>::max() / 2;
  if (lanes.largest_id > kLargestId) {
    return Error{ErrorCode::kMalformedText, "its ids are too large: no new ids can be added"};
  }
  WeakStretchOptions weakness;
  weakness.limit_m = info.limits_m[area_limit];
  weakness.least_margin = options.weak_margin;
  SIGHTLINE_ASSIGN(WeakPlaces weak, WeakPlaces::of(map, weakness));
  SIGHTLINE_ASSIGN(const LaneAsker asker,
                   LaneAsker::of(reader, map.sensor.height_m, std::move(weak)));
  Lanelet2Export made;
  OsmAdditions additions;
  additions.of_relations.resize(lanes.relation_count);
  AreaMaker areas(lanes, info.limits_m[area_limit], additions);
  for (const Lanelet& lanelet : lanes.lanelets) {
    SIGHTLINE_ASSIGN(const LaneAnswers answers, asker.ask(lanelet));
    additions.of_relations[lanelet.relation] = tags_of(answers, info);
    if (answers.known_share == 0.0) made.outside.push_back(lanelet.id);
    if (!lanelet.is_for_vehicles) continue;
    for (const LaneStretch& stretch : answers.limits[area_limit].unmet) {
      areas.add(lanelet, stretch, "feature_poor_road");
      ++made.area_count;
    }
    for (const LaneStretch& stretch : answers.limits[area_limit].weak) {
      areas.add(lanelet, stretch, "feature_weak_road");
      ++made.weak_area_count;
    }
  }
  made.lanelet_count = lanes.lanelets.size();
  if (made.outside.size() == made.lanelet_count) {
    return Error{
        ErrorCode::kNoOverlap,
        concat("no lanelet is on the route of the map: horizontally, the nearest is ",
               rounded(distance_m(lanes, asker)), " m away; check that both are in the world ",
               info.world, " and that their heights have the same datum")};
  }
  SIGHTLINE_ASSIGN(made.text, with_additions(clean, additions));
  return made;
}

}  // namespace sightline
