#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/foreign/lanes/lane_geometry.h"
#include "formats/foreign/lanes/route_parsers.h"

// The lanes of a Lanelet2 map in OpenStreetMap's XML: nodes with places, ways of nodes, relations
// of ways. A lanelet is a relation with a way on its left and one on its right; which is which
// decides its direction, not the order of the nodes (Poggenhans et al., Lanelet2, ITSC 2018).

namespace sightline {

// A node of a lanelet's side. What its file does not say is not there.
struct LaneletNode {
  std::string id;
  std::optional<double> latitude_deg;
  std::optional<double> longitude_deg;
  std::optional<double> height_m;
  std::optional<double> local_x_m;
  std::optional<double> local_y_m;
};

// One side, from the lanelet's begin to its end.
struct LaneletSide {
  std::vector<std::size_t> nodes;  // indices into LaneletMap::nodes; two or more
  // Where they are, in world coordinates; NaN as the height of a node that has none.
  std::vector<Eigen::Vector3d> points_m;
};

struct Lanelet {
  std::string id;
  std::size_t relation = 0;  // so many relations stand before it among the children of <osm>
  bool is_for_vehicles = true;
  bool is_both_ways = false;
  LaneletSide left;
  LaneletSide right;
  // A place of a lanelet is a share of both sides, which need not be of one length: this is that of
  // the longer one, m.
  double length_m = 0.0;
};

struct LaneletMap {
  std::vector<LaneletNode> nodes;  // those that sides of lanelets name, each once
  std::vector<Lanelet> lanelets;   // in the order of the file
  std::int64_t largest_id = 0;     // of all elements whose id is a number
  std::size_t relation_count = 0;
};

enum class LaneletsRead : std::uint8_t { kAll, kForVehicles };

// A lanelet is at most this long, and the file's sides have at most so many nodes, each counted for
// each lanelet that names it: what a small file can cost is bounded.
inline constexpr double kLongestLanelet_m = 1e5;
inline constexpr std::size_t kMostSideNodes = std::size_t{1} << 23;

// Errors: malformed-text (no XML, no <osm>, a way or node that is not there, a lanelet without
// sides or too long, too many nodes), missing-field (a node without a place), bad-argument (a place
// outside the file's world).
Result<LaneletMap> read_lanelets(const RouteText& file, LaneletsRead which);

}  // namespace sightline
