#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>

#include "formats/foreign/lanes/route_parsers.h"
#include "formats/foreign/text/text_lines.h"

// Lanelet2 keeps its map as OpenStreetMap does: nodes with places, ways of nodes, relations of
// ways. A lanelet is a relation with a way on its left and one on its right; which is which decides
// its direction, not the order of the nodes (Poggenhans et al., Lanelet2, ITSC 2018).

namespace sightline {
namespace {

using tinyxml2::XMLElement;

using Points = std::vector<Eigen::Vector3d>;
using NodeIds = std::vector<std::string_view>;

// The elements by their ids, which are any numbers. Views into the document.
struct Elements {
  std::unordered_map<std::string_view, const XMLElement*> nodes;
  std::unordered_map<std::string_view, const XMLElement*> ways;
};

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

std::optional<double> finite_number(std::string_view text) {
  const std::optional<double> number = to_number<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::string place_of(const XMLElement& element) {
  return std::string(element.Name()) + " " + std::string(attribute(element, "id")).substr(0, 40) +
         ", line " + std::to_string(element.GetLineNum());
}

// In the map's coordinates; NaN as the height where the node has none.
Result<Eigen::Vector3d> place_of_node(const RouteText& file, const XMLElement& node) {
  const std::optional<double> height_m = finite_number(tag(node, "ele"));
  if (file.world.kind == WorldKind::kLocal) {
    const std::optional<double> x_m = finite_number(tag(node, "local_x"));
    const std::optional<double> y_m = finite_number(tag(node, "local_y"));
    if (x_m && y_m) return Eigen::Vector3d(*x_m, *y_m, height_m.value_or(kNoHeight));
    return file.error(ErrorCode::kMissingField,
                      "the node has no local_x and local_y: say how the map lies on Earth, "
                      "route.world: utm:32N",
                      place_of(node));
  }
  const std::optional<double> latitude_deg = finite_number(attribute(node, "lat"));
  const std::optional<double> longitude_deg = finite_number(attribute(node, "lon"));
  if (!latitude_deg || !longitude_deg) {
    return file.error(ErrorCode::kMissingField, "the node has no latitude and longitude",
                      place_of(node));
  }
  SIGHTLINE_ASSIGN(
      Eigen::Vector3d place_m,
      from_geodetic(file.world, {*latitude_deg, *longitude_deg, height_m.value_or(0.0)}));
  if (!height_m) place_m.z() = kNoHeight;
  return place_m;
}

Result<void> append_way(const RouteText& file, const Elements& elements, const XMLElement& way,
                        Points& points_m) {
  for (const XMLElement* ref = way.FirstChildElement("nd"); ref != nullptr;
       ref = ref->NextSiblingElement("nd")) {
    const auto node = elements.nodes.find(attribute(*ref, "ref"));
    if (node == elements.nodes.end()) {
      return file.error(ErrorCode::kMalformedText, "it names a node that is not there",
                        place_of(way));
    }
    SIGHTLINE_ASSIGN(const Eigen::Vector3d point_m, place_of_node(file, *node->second));
    points_m.push_back(point_m);
  }
  return {};
}

// The points of the way that plays a role in a relation; empty where none does.
Result<Points> way_of_role(const RouteText& file, const Elements& elements,
                           const XMLElement& lanelet, std::string_view role) {
  Points points_m;
  for (const XMLElement* member = lanelet.FirstChildElement("member"); member != nullptr;
       member = member->NextSiblingElement("member")) {
    if (attribute(*member, "role") != role || attribute(*member, "type") != "way") continue;
    const auto way = elements.ways.find(attribute(*member, "ref"));
    if (way == elements.ways.end()) {
      return file.error(ErrorCode::kMalformedText, "its " + std::string(role) + " way is not there",
                        place_of(lanelet));
    }
    SIGHTLINE_TRY(append_way(file, elements, *way->second, points_m));
  }
  return points_m;
}

double length_m(const Points& points_m) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i) {
    sum_m += (points_m[i] - points_m[i - 1]).head<2>().norm();
  }
  return sum_m;
}

// At a share of its length, in the plane.
Eigen::Vector3d at_share(const Points& points_m, double share) {
  double left_m = share * length_m(points_m);
  for (std::size_t i = 1; i < points_m.size(); ++i) {
    const double step_m = (points_m[i] - points_m[i - 1]).head<2>().norm();
    if (left_m <= step_m && step_m > 0.0) {
      return points_m[i - 1] + left_m / step_m * (points_m[i] - points_m[i - 1]);
    }
    left_m -= step_m;
  }
  return points_m.back();
}

// Above 0 where `p` lies on the left of a line that is followed from its begin to its end.
double left_of(const Points& line_m, const Eigen::Vector3d& p_m) {
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

// Halfway between the two sides, a point every half metre at most.
Points middle_of(Points left_m, Points right_m) {
  constexpr double kStep_m = 0.5;
  if (left_of(left_m, at_share(right_m, 0.5)) > 0.0) std::ranges::reverse(left_m);
  if (left_of(right_m, at_share(left_m, 0.5)) < 0.0) std::ranges::reverse(right_m);
  const double longer_m = std::max(length_m(left_m), length_m(right_m));
  const auto steps = static_cast<std::size_t>(std::ceil(longer_m / kStep_m));
  Points points_m;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double share = steps == 0 ? 0.0 : static_cast<double>(i) / static_cast<double>(steps);
    points_m.push_back(0.5 * (at_share(left_m, share) + at_share(right_m, share)));
  }
  return points_m;
}

// By its subtype, unless it says itself.
bool is_for_vehicles(const XMLElement& lanelet) {
  const std::string_view said = tag(lanelet, "participant:vehicle");
  if (said == "yes" || said == "no") return said == "yes";
  constexpr std::string_view kNot[] = {"crosswalk",       "walkway",      "shared_walkway",
                                       "stairs",          "bicycle_lane", "exit",
                                       "pedestrian_lane", "road_shoulder"};
  return std::ranges::find(kNot, tag(lanelet, "subtype")) == std::end(kNot);
}

Result<void> append_lanelet(const RouteText& file, const Elements& elements,
                            const XMLElement& lanelet, Route& route) {
  SIGHTLINE_ASSIGN(const Points left_m, way_of_role(file, elements, lanelet, "left"));
  SIGHTLINE_ASSIGN(const Points right_m, way_of_role(file, elements, lanelet, "right"));
  if (left_m.size() < 2 || right_m.size() < 2) {
    return file.error(ErrorCode::kMalformedText,
                      "a lanelet needs a way of two nodes or more on its left and on its right",
                      place_of(lanelet));
  }
  RouteLine line = line_of_points("lanelet " + std::string(attribute(lanelet, "id")),
                                  middle_of(left_m, right_m));
  if (line.points_world_m.size() < 2) return {};
  line.is_both_ways = tag(lanelet, "one_way") == "no";
  route.lines.push_back(std::move(line));
  return {};
}

}  // namespace

Result<void> parse_lanelets(const RouteText& file, Route& route) {
  tinyxml2::XMLDocument document;
  if (document.Parse(file.text.data(), file.text.size()) != tinyxml2::XML_SUCCESS) {
    return file.error(ErrorCode::kMalformedText, "this is no XML",
                      "line " + std::to_string(document.ErrorLineNum()));
  }
  const XMLElement* root = document.FirstChildElement("osm");
  if (root == nullptr) return file.error(ErrorCode::kMalformedText, "found no element osm");
  Elements elements;
  for (const XMLElement* child = root->FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    const std::string_view name = child->Name();
    if (name == "node") elements.nodes[attribute(*child, "id")] = child;
    if (name == "way") elements.ways[attribute(*child, "id")] = child;
  }
  std::size_t lanelet_count = 0;
  for (const XMLElement* child = root->FirstChildElement("relation"); child != nullptr;
       child = child->NextSiblingElement("relation")) {
    if (tag(*child, "type") != "lanelet") continue;
    ++lanelet_count;
    if (!is_for_vehicles(*child)) continue;
    SIGHTLINE_TRY(append_lanelet(file, elements, *child, route));
  }
  if (!route.lines.empty()) return {};
  return file.error(ErrorCode::kMissingField, "found " + std::to_string(lanelet_count) +
                                                  " lanelets, none of them for vehicles");
}

}  // namespace sightline
