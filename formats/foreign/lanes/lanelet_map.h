#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/foreign/lanes/read_route.h"

// The lanes of a Lanelet2 map in OpenStreetMap's XML. A lanelet is a relation with a way on its
// left and one on its right, which decides its direction (Poggenhans et al., Lanelet2, ITSC 2018).

namespace sightline {

// Lines of lanes in the plane. Points are in world coordinates, m; lengths leave heights out.

// A line that is asked for places by their share of its length. One point or more.
class LineByShare {
 public:
  explicit LineByShare(std::vector<Eigen::Vector3d> points_m);
  [[nodiscard]] double length_m() const { return until_m_.back(); }
  // The begin of the segment that the place lies in, and where between its ends, 0 to 1.
  struct Place {
    std::size_t segment = 0;
    double within = 0.0;
  };
  [[nodiscard]] Place place(double share) const;  // 0: the begin, 1: the end
  [[nodiscard]] Eigen::Vector3d at(double share) const;
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }

 private:
  std::vector<Eigen::Vector3d> points_m_;
  std::vector<double> until_m_;  // from the begin to each point
};

// Above 0 where a place lies on the left of a line that is followed from its begin to its end.
double left_of(const std::vector<Eigen::Vector3d>& line_m, const Eigen::Vector3d& p_m);

// Halfway between places of equal share of two lines that run the same way, steps + 1 points.
std::vector<Eigen::Vector3d> middle_of(const LineByShare& left, const LineByShare& right,
                                       std::size_t steps);

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
  std::vector<std::string> warnings;  // lanelets that are broken and left out
};

enum class LaneletsRead : std::uint8_t { kAll, kForVehicles };

// The longest lanelet, and the most nodes of all sides: bounds what a small file can cost.
inline constexpr double kLongestLanelet_m = 1e5;
inline constexpr std::size_t kMostSideNodes = std::size_t{1} << 23;

// Without elements that JOSM marks as deleted, and, with a warning, without broken lanelets: a way
// or node that is not there or has no place, no sides, too long, outside the file's world. Errors:
// malformed-text (no XML, no <osm>, too many nodes), and that of the first broken lanelet where all
// are: malformed-text, missing-field, bad-argument.
Result<LaneletMap> read_lanelets(const RouteText& file, LaneletsRead which);

}  // namespace sightline
