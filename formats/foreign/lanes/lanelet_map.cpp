#include "formats/foreign/lanes/lanelet_map.h"

#include <tinyxml2.h>
#include <algorithm>
#include <limits>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "formats/base/check.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

using tinyxml2::XMLElement;

std::string_view attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

std::string_view tag(const XMLElement& element, std::string_view key) {
  for (const XMLElement* child = element.FirstChildElement("tag"); child != nullptr;
       child = child->NextSiblingElement("tag")) {
    if (attribute(*child, "k") == key) return attribute(*child, "v");
  }
  return {};
}

std::string place_of(const XMLElement& element) {
  return concat(element.Name(), " ", std::string(attribute(element, "id")).substr(0, 40), ", line ",
                element.GetLineNum());
}

// JOSM keeps what was deleted in its files, marked.
bool is_deleted(const XMLElement& element) { return attribute(element, "action") == "delete"; }

// By its subtype, unless it says itself.
bool is_for_vehicles(const XMLElement& lanelet) {
  const std::string_view said = tag(lanelet, "participant:vehicle");
  if (said == "yes" || said == "no") return said == "yes";
  constexpr std::string_view kNot[] = {"crosswalk",       "walkway",      "shared_walkway",
                                       "stairs",          "bicycle_lane", "exit",
                                       "pedestrian_lane", "road_shoulder"};
  return std::ranges::find(kNot, tag(lanelet, "subtype")) == std::end(kNot);
}

// Reads one document; refers into it.
class LaneletReader {
 public:
  explicit LaneletReader(const RouteText& file) : file_(file) {}

  Result<LaneletMap> read(const XMLElement& root, LaneletsRead which) {
    index(root);
    for (const XMLElement* child = root.FirstChildElement("relation"); child != nullptr;
         child = child->NextSiblingElement("relation")) {
      const std::size_t relation = map_.relation_count++;
      if (tag(*child, "type") != "lanelet" || is_deleted(*child)) continue;
      if (which == LaneletsRead::kForVehicles && !is_for_vehicles(*child)) continue;
      Result<Lanelet> lanelet = read_lanelet(*child);
      if (lanelet) {
        lanelet->relation = relation;
        map_.lanelets.push_back(*std::move(lanelet));
      } else if (side_node_count_ > kMostSideNodes) {
        return lanelet.error();
      } else {
        broken_.push_back(lanelet.error());
      }
    }
    if (broken_.empty()) return std::move(map_);
    if (map_.lanelets.empty()) return broken_.front();
    map_.warnings.push_back(
        concat(broken_.size(), " of ", map_.lanelets.size() + broken_.size(),
               " lanelets are broken and left out, the first: ", to_string(broken_.front())));
    return std::move(map_);
  }

 private:
  void index(const XMLElement& root) {
    for (const XMLElement* child = root.FirstChildElement(); child != nullptr;
         child = child->NextSiblingElement()) {
      if (is_deleted(*child)) continue;
      const std::string_view name = child->Name();
      const std::string_view id = attribute(*child, "id");
      if (name == "node") nodes_[id] = child;
      if (name == "way") ways_[id] = child;
      if (const std::optional<std::int64_t> number = to_number<std::int64_t>(id)) {
        map_.largest_id = std::max(map_.largest_id, *number);
      }
    }
  }

  // NaN as the height where the node has none.
  Result<Eigen::Vector3d> place_of_node(const LaneletNode& node, const XMLElement& element) const {
    if (file_.world.kind == WorldKind::kLocal) {
      if (node.local_x_m && node.local_y_m) {
        const Eigen::Vector2d p_m =
            Eigen::Vector2d(*node.local_x_m, *node.local_y_m) + file_.local_origin_world_m;
        return Eigen::Vector3d(p_m.x(), p_m.y(), node.height_m.value_or(kNoHeight));
      }
      return file_.error(ErrorCode::kMissingField,
                         "the node has no local_x and local_y. Name the map's coordinate system, "
                         "for example route.world: utm:32N",
                         place_of(element));
    }
    if (!node.latitude_deg || !node.longitude_deg) {
      return file_.error(ErrorCode::kMissingField, "the node has no latitude and longitude",
                         place_of(element));
    }
    const Geodetic place{*node.latitude_deg, *node.longitude_deg, node.height_m.value_or(0.0)};
    SIGHTLINE_ASSIGN(Eigen::Vector3d p_m, from_geodetic(file_.world, place));
    if (!node.height_m) p_m.z() = kNoHeight;
    return p_m;
  }

  // The number of a node among those read, and where it is.
  Result<std::size_t> read_node(std::string_view id, const XMLElement& way) {
    const auto found = number_of_.find(id);
    if (found != number_of_.end()) return found->second;
    const auto element = nodes_.find(id);
    if (element == nodes_.end()) {
      return file_.error(ErrorCode::kMalformedText, "it refers to a node that is missing",
                         place_of(way));
    }
    const XMLElement& said = *element->second;
    LaneletNode node;
    node.id = std::string(id);
    node.latitude_deg = finite_number(attribute(said, "lat"));
    node.longitude_deg = finite_number(attribute(said, "lon"));
    node.height_m = finite_number(tag(said, "ele"));
    node.local_x_m = finite_number(tag(said, "local_x"));
    node.local_y_m = finite_number(tag(said, "local_y"));
    SIGHTLINE_ASSIGN(const Eigen::Vector3d place_m, place_of_node(node, said));
    if (!is_place(place_m)) return file_.too_far(place_of(said));
    map_.nodes.push_back(std::move(node));
    places_m_.push_back(place_m);
    return number_of_[id] = places_m_.size() - 1;
  }

  Result<void> append_way(const XMLElement& way, LaneletSide& side) {
    for (const XMLElement* ref = way.FirstChildElement("nd"); ref != nullptr;
         ref = ref->NextSiblingElement("nd")) {
      if (++side_node_count_ > kMostSideNodes) {
        return file_.error(ErrorCode::kMalformedText,
                           concat("its lanelets have more than ", kMostSideNodes, " nodes"));
      }
      SIGHTLINE_ASSIGN(const std::size_t node, read_node(attribute(*ref, "ref"), way));
      side.nodes.push_back(node);
      side.points_m.push_back(places_m_[node]);
    }
    return {};
  }

  // Of the ways that play a role in a relation; empty where none does.
  Result<LaneletSide> read_side(const XMLElement& lanelet, std::string_view role) {
    LaneletSide side;
    for (const XMLElement* member = lanelet.FirstChildElement("member"); member != nullptr;
         member = member->NextSiblingElement("member")) {
      if (attribute(*member, "role") != role || attribute(*member, "type") != "way") continue;
      const auto way = ways_.find(attribute(*member, "ref"));
      if (way == ways_.end()) {
        return file_.error(ErrorCode::kMalformedText, concat("its ", role, " way is missing"),
                           place_of(lanelet));
      }
      SIGHTLINE_TRY(append_way(*way->second, side));
    }
    return side;
  }

  Result<Lanelet> read_lanelet(const XMLElement& element) {
    Lanelet lanelet;
    SIGHTLINE_ASSIGN(lanelet.left, read_side(element, "left"));
    SIGHTLINE_ASSIGN(lanelet.right, read_side(element, "right"));
    if (lanelet.left.nodes.size() < 2 || lanelet.right.nodes.size() < 2) {
      return file_.error(ErrorCode::kMalformedText,
                         "a lanelet needs a way of two nodes or more on its left and on its right",
                         place_of(element));
    }
    lanelet.id = std::string(attribute(element, "id"));
    lanelet.is_for_vehicles = is_for_vehicles(element);
    lanelet.is_both_ways = tag(element, "one_way") == "no";
    align(lanelet);
    if (lanelet.length_m <= kLongestLanelet_m) return lanelet;
    return file_.error(ErrorCode::kMalformedText, "a lanelet is longer than 100 km",
                       place_of(element));
  }

  static void reverse(LaneletSide& side) {
    std::ranges::reverse(side.nodes);
    std::ranges::reverse(side.points_m);
  }

  // Turns both sides into the lanelet's direction.
  static void align(Lanelet& lanelet) {
    LaneletSide& left = lanelet.left;
    LaneletSide& right = lanelet.right;
    const LineByShare of_left(left.points_m);
    const LineByShare of_right(right.points_m);
    if (left_of(left.points_m, of_right.at(0.5)) > 0.0) reverse(left);
    if (left_of(right.points_m, of_left.at(0.5)) < 0.0) reverse(right);
    // Of the sides as they are now: the other way round a sum of lengths may round otherwise.
    lanelet.length_m =
        std::max(LineByShare(left.points_m).length_m(), LineByShare(right.points_m).length_m());
  }

  const RouteText& file_;
  // The elements by their ids, which are any words.
  std::unordered_map<std::string_view, const XMLElement*> nodes_;
  std::unordered_map<std::string_view, const XMLElement*> ways_;
  std::unordered_map<std::string_view, std::size_t> number_of_;
  std::vector<Eigen::Vector3d> places_m_;  // of map_.nodes
  std::size_t side_node_count_ = 0;
  std::vector<Error> broken_;  // of lanelets
  LaneletMap map_;
};

}  // namespace

Result<LaneletMap> read_lanelets(const RouteText& file, LaneletsRead which) {
  tinyxml2::XMLDocument document;
  if (document.Parse(file.text.data(), file.text.size()) != tinyxml2::XML_SUCCESS) {
    return file.error(ErrorCode::kMalformedText, "the file is not valid XML",
                      concat("line ", document.ErrorLineNum()));
  }
  const XMLElement* root = document.FirstChildElement("osm");
  if (root == nullptr) return file.error(ErrorCode::kMalformedText, "found no element osm");
  return LaneletReader(file).read(*root, which);
}

LineByShare::LineByShare(std::vector<Eigen::Vector3d> points_m) : points_m_(std::move(points_m)) {
  SIGHTLINE_CHECK(!points_m_.empty());
  until_m_.push_back(0.0);
  for (std::size_t i = 1; i < points_m_.size(); ++i) {
    until_m_.push_back(until_m_.back() + (points_m_[i] - points_m_[i - 1]).head<2>().norm());
  }
}

LineByShare::Place LineByShare::place(double share) const {
  if (share >= 1.0 || points_m_.size() == 1) {
    return points_m_.size() == 1 ? Place{} : Place{points_m_.size() - 2, 1.0};
  }
  const double at_m = share * length_m();
  const auto after = std::upper_bound(until_m_.begin() + 1, until_m_.end() - 1, at_m);
  const auto segment = static_cast<std::size_t>(after - until_m_.begin()) - 1;
  const double step_m = until_m_[segment + 1] - until_m_[segment];
  return {segment, step_m > 0.0 ? (at_m - until_m_[segment]) / step_m : 0.0};
}

Eigen::Vector3d LineByShare::at(double share) const {
  const Place found = place(share);
  if (found.within == 0.0) return points_m_[found.segment];
  if (found.within == 1.0) return points_m_[found.segment + 1];
  const Eigen::Vector3d step_m = points_m_[found.segment + 1] - points_m_[found.segment];
  return points_m_[found.segment] + found.within * step_m;
}

double left_of(const std::vector<Eigen::Vector3d>& line_m, const Eigen::Vector3d& p_m) {
  double nearest_m = std::numeric_limits<double>::infinity();
  double side = 0.0;
  for (std::size_t i = 1; i < line_m.size(); ++i) {
    const Eigen::Vector2d along_m = (line_m[i] - line_m[i - 1]).head<2>();
    const Eigen::Vector2d to_m = (p_m - line_m[i - 1]).head<2>();
    const double squared = along_m.squaredNorm();
    if (squared == 0.0) continue;
    const double share = std::clamp(to_m.dot(along_m) / squared, 0.0, 1.0);
    const double distance_m = (to_m - share * along_m).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    side = along_m.x() * to_m.y() - along_m.y() * to_m.x();
  }
  return side;
}

std::vector<Eigen::Vector3d> middle_of(const LineByShare& left, const LineByShare& right,
                                       std::size_t steps) {
  std::vector<Eigen::Vector3d> points_m;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double share = steps == 0 ? 0.0 : static_cast<double>(i) / static_cast<double>(steps);
    points_m.emplace_back(0.5 * (left.at(share) + right.at(share)));
  }
  return points_m;
}

Result<void> parse_lanelets(const RouteText& file, Route& route) {
  constexpr double kStep_m = 0.5;
  SIGHTLINE_ASSIGN(const LaneletMap map, read_lanelets(file, LaneletsRead::kForVehicles));
  route.warnings = map.warnings;
  double total_m = 0.0;
  for (const Lanelet& lanelet : map.lanelets) {
    total_m += lanelet.length_m;
    if (total_m > kLongestRoute_m) {
      return file.error(ErrorCode::kMalformedText, "its lanelets are longer than 10000 km");
    }
    const auto steps = static_cast<std::size_t>(std::ceil(lanelet.length_m / kStep_m));
    RouteLine line = line_of_points(
        "lanelet " + lanelet.id,
        middle_of(LineByShare(lanelet.left.points_m), LineByShare(lanelet.right.points_m), steps));
    if (line.points_world_m.size() < 2) continue;
    line.is_both_ways = lanelet.is_both_ways;
    route.lines.push_back(std::move(line));
  }
  if (!route.lines.empty()) return {};
  return file.error(ErrorCode::kMissingField, concat("found no lanelet for vehicles among ",
                                                     map.relation_count, " relations"));
}

}  // namespace sightline
