// Lines that a map is annotated along: Lanelet2, GeoJSON and CSV, in a local world and in one of
// UTM. The first byte decides which; the rest is the file.

#include <string>

#include "formats/foreign/lanes/lanelet_map.h"
#include "formats/foreign/lanes/osm_text.h"
#include "formats/foreign/lanes/read_route.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

void check(const Error& error) { check_refusal(error, {ErrorCode::kBadArgument}); }

void check(const Route& route) {
  for (const RouteLine& line : route.lines) {
    SIGHTLINE_CHECK(line.points_world_m.size() >= 2);
    for (std::size_t i = 0; i < line.points_world_m.size(); ++i) {
      const Eigen::Vector3d& p_m = line.points_world_m[i];
      SIGHTLINE_CHECK(p_m.allFinite());
      SIGHTLINE_CHECK(is_place(p_m));
      SIGHTLINE_CHECK(line.heights != RouteHeights::kNone || p_m.z() == 0.0);
      SIGHTLINE_CHECK(i == 0 || p_m != line.points_world_m[i - 1]);
    }
  }
}

using Parser = Result<void> (*)(const RouteText& file, Route& route);

void read_lines(const RouteText& file, Parser parse) {
  Route route;
  if (const Result<void> read = parse(file, route); !read) return check(read.error());
  check(route);
  if (route.lines.empty()) return;
  SIGHTLINE_CHECK(validate(route).has_value());
}

// A side is as the file has it, and the left one lies on the left.
void check(const Lanelet& lanelet, std::size_t node_count) {
  for (const LaneletSide* side : {&lanelet.left, &lanelet.right}) {
    SIGHTLINE_CHECK(side->nodes.size() >= 2 && side->nodes.size() == side->points_m.size());
    for (const std::size_t node : side->nodes) SIGHTLINE_CHECK(node < node_count);
    const LineByShare line(side->points_m);
    SIGHTLINE_CHECK(line.length_m() <= lanelet.length_m && lanelet.length_m <= kLongestLanelet_m);
    for (const double share : {0.0, 0.3, 1.0}) {
      SIGHTLINE_CHECK(line.at(share).head<2>().allFinite());
      SIGHTLINE_CHECK(line.place(share).segment + 1 < side->nodes.size());
    }
  }
}

void add_to(const RouteText& file, const LaneletMap& map) {
  const std::vector<std::string_view> keys = {"observation_range_"};
  const Result<std::string> clean = without_additions(file.text, keys);
  if (!clean) return check(clean.error());
  if (*clean != file.text) return;
  OsmAdditions additions;
  additions.of_relations.resize(map.relation_count);
  for (const Lanelet& lanelet : map.lanelets) {
    additions.of_relations[lanelet.relation] = {{"observation_range_010", "<\"&'>"}};
  }
  additions.nodes = {{"node id=\"-77777\"", {}, {}}};
  additions.ways = {{"way id=\"-77777\"", {"-77777"}, {{"area", "yes"}}}};
  const Result<std::string> added = with_additions(*clean, additions);
  if (!added) return check(added.error());
  const Result<LaneletMap> again =
      read_lanelets({*added, file.file, file.world}, LaneletsRead::kAll);
  SIGHTLINE_CHECK(again.has_value() && again->relation_count == map.relation_count);
  SIGHTLINE_CHECK(again->lanelets.size() == map.lanelets.size());
  for (std::size_t i = 0; i < map.lanelets.size(); ++i) {
    SIGHTLINE_CHECK(again->lanelets[i].left.nodes == map.lanelets[i].left.nodes);
    SIGHTLINE_CHECK(again->lanelets[i].length_m == map.lanelets[i].length_m);
  }
  const Result<std::string> without = without_additions(*added, keys);
  SIGHTLINE_CHECK(without.has_value() && without->size() < added->size());
  const Result<std::string> twice = with_additions(*without, additions);
  SIGHTLINE_CHECK(twice.has_value() && *twice == *added);
}

void read_lanelet_map(const RouteText& file) {
  const Result<LaneletMap> map = read_lanelets(file, LaneletsRead::kAll);
  if (!map) return check(map.error());
  if (!map->lanelets.empty()) add_to(file, *map);
  for (const Lanelet& lanelet : map->lanelets) {
    check(lanelet, map->nodes.size());
    SIGHTLINE_CHECK(lanelet.relation < map->relation_count);
  }
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  const FuzzInput input(data + 1, size - 1);
  const std::string_view text(reinterpret_cast<const char*>(input.bytes().data()), size - 1);
  const World world =
      data[0] % 2 == 0 ? World{} : World{.kind = WorldKind::kUtm, .utm_zone = 32, .is_north = true};
  const RouteText file{text, "lanes", world};
  switch (data[0] / 2 % 3) {
    case 0:
      read_lines(file, parse_lanelets);
      read_lanelet_map(file);
      break;
    case 1:
      read_lines(file, parse_geojson);
      break;
    default:
      read_lines(file, parse_csv_lines);
  }
  return 0;
}
