#include "passes/trajectory/local/wider_starts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <queue>
#include <tuple>

#include "formats/grid/cell_index.h"
#include "formats/grid/cell_key.h"

// Branch and bound over heading and place. A node is a heading and a square of places; its bound
// counts the scan's points that meet a cell of the map anywhere in the square, which a pyramid of
// grids answers with one look a point, for all four quarters of a square at once. The best node is
// opened first, so the first squares of one cell that come out are the best there are.

namespace sightline {
namespace {

constexpr double kCell_m = 0.5;
constexpr double kScanReach_m = 40.0;
constexpr int kLevels = 6;  // squares of 1 to 32 cells
constexpr std::size_t kMostOpened = 200'000;
constexpr double kDistinct_m = 1.5;
constexpr double kDistinct_rad = 10.0 * std::numbers::pi / 180.0;

struct Offset {
  std::int32_t x = 0;
  std::int32_t y = 0;
};

// Heights are in layers, one bit each, from this far below the sensor; lower and higher points
// count to the first and the last.
constexpr int kLayers = 8;
constexpr double kLayer_m = 1.0;
constexpr double kLowest_m = -3.0;

int layer_of(double off_m) {
  return std::clamp(floor_to_int((off_m - kLowest_m) / kLayer_m), 0, kLayers - 1);
}

// In which layers the map has cells, for squares of places.
class Pyramid {
 public:
  // Cells from -half to half along both axes.
  Pyramid(const std::vector<Eigen::Vector3d>& points_m, const Eigen::Vector3d& middle_m, int half)
      : half_(half), size_(2 * half + 1) {
    const auto side = static_cast<std::size_t>(size_);
    std::vector<std::uint8_t> level(side * side, 0);
    for (const Eigen::Vector3d& point_m : points_m) mark(point_m - middle_m, level);
    for (int h = 1; h <= kLevels; ++h) {
      quarters_.push_back(quarters_of(level, 1 << (h - 1)));
      level = joined(quarters_.back());
    }
  }

  // quarters(h)[place_of(x, y)]: a byte for each quarter of the square of 2^h cells that begins
  // there, first that at (x, y), then that beyond it along x, along y, along both. A bit for each
  // layer in which the map has a cell in that quarter.
  [[nodiscard]] const std::vector<std::uint32_t>& quarters(int h) const {
    return quarters_[static_cast<std::size_t>(h - 1)];
  }
  [[nodiscard]] std::int32_t place_of(int x, int y) const { return row(y + half_) + x + half_; }
  // To the place so many cells farther.
  [[nodiscard]] std::int32_t row(int y) const { return y * size_; }

 private:
  // A point counts for the cells and layers within half a cell, half a layer of it.
  void mark(const Eigen::Vector3d& off_m, std::vector<std::uint8_t>& level) const {
    const double half_layer_m = 0.5 * kLayer_m;
    const unsigned bits =
        1U << layer_of(off_m.z() - half_layer_m) | 1U << layer_of(off_m.z() + half_layer_m);
    for (const double dx : {-0.25, 0.25}) {
      for (const double dy : {-0.25, 0.25}) {
        const int x = floor_to_int(off_m.x() / kCell_m + dx);
        const int y = floor_to_int(off_m.y() / kCell_m + dy);
        if (std::abs(x) > half_ || std::abs(y) > half_) continue;
        std::uint8_t& cell = level[static_cast<std::size_t>(place_of(x, y))];
        cell = static_cast<std::uint8_t>(cell | bits);
      }
    }
  }

  [[nodiscard]] std::vector<std::uint32_t> quarters_of(const std::vector<std::uint8_t>& level,
                                                       int side) const {
    std::vector<std::uint32_t> quarters(level.size());
    for (int y = 0; y < size_; ++y) {
      for (int x = 0; x < size_; ++x) {
        const std::int32_t place = row(y) + x;
        const auto at = static_cast<std::size_t>(place);
        const auto beyond = static_cast<std::size_t>(side);
        const auto above = static_cast<std::size_t>(row(side));
        const bool has_beyond = x + side < size_;
        const bool has_above = y + side < size_;
        std::uint32_t bytes = level[at];
        if (has_beyond) bytes |= std::uint32_t{level[at + beyond]} << 8;
        if (has_above) bytes |= std::uint32_t{level[at + above]} << 16;
        if (has_beyond && has_above) bytes |= std::uint32_t{level[at + above + beyond]} << 24;
        quarters[at] = bytes;
      }
    }
    return quarters;
  }

  static std::vector<std::uint8_t> joined(const std::vector<std::uint32_t>& quarters) {
    std::vector<std::uint8_t> level;
    level.reserve(quarters.size());
    for (const std::uint32_t bytes : quarters) {
      level.push_back(static_cast<std::uint8_t>(bytes | bytes >> 8 | bytes >> 16 | bytes >> 24));
    }
    return level;
  }

  int half_;
  int size_;
  std::vector<std::vector<std::uint32_t>> quarters_;
};

// A point of the scan at one heading: how far it is from the pose in the pyramid, and its layer.
struct ScanCell {
  std::int32_t offset = 0;
  int layer = 0;
};

struct Node {
  unsigned bound = 0;
  int level = 0;
  int heading = 0;
  Offset place;
};

// The order in which nodes are opened; smaller squares first, then ties by place.
struct IsOpenedLater {
  bool operator()(const Node& a, const Node& b) const {
    const auto order = [](const Node& n) {
      return std::tuple(n.bound, -n.level, -n.heading, -n.place.x, -n.place.y);
    };
    return order(a) < order(b);
  }
};

// One point in a cell, as many as are needed, evenly over the list.
std::vector<Eigen::Vector3d> thinned_in_plane(const std::vector<Eigen::Vector3d>& points_m,
                                              std::size_t most_points) {
  CellTable<std::uint8_t> cells;
  std::vector<Eigen::Vector3d> kept_m;
  for (const Eigen::Vector3d& point_m : points_m) {
    if (point_m.head<2>().norm() > kScanReach_m) continue;
    const CellKey key{floor_to_int(point_m.x() / kCell_m), floor_to_int(point_m.y() / kCell_m),
                      floor_to_int(point_m.z() / kLayer_m)};
    if (cells.insert(key).is_new) kept_m.push_back(point_m);
  }
  if (kept_m.size() <= most_points) return kept_m;
  std::vector<Eigen::Vector3d> few_m;
  for (std::size_t i = 0; i < most_points; ++i) {
    few_m.push_back(kept_m[i * kept_m.size() / most_points]);
  }
  return few_m;
}

class Search {
 public:
  Search(const std::vector<Eigen::Vector3d>& map_upright_m, const Pose& T_map_around,
         const WideSearch& options)
      : T_map_around_(T_map_around),
        options_(options),
        reach_(static_cast<int>(std::ceil(options.reach_m / kCell_m))),
        pyramid_(map_upright_m, T_map_around.translation(),
                 reach_ + static_cast<int>(kScanReach_m / kCell_m) + 2) {
    for (int heading = 0; heading < options_.headings; ++heading) {
      rotations_.push_back(rotation_matrix(
          {Eigen::Vector3d::UnitZ(), 2.0 * std::numbers::pi * heading / options_.headings}));
    }
  }

  std::vector<WiderStart> best(const std::vector<Eigen::Vector3d>& scan_upright_m) {
    turn(scan_upright_m);
    if (turned_.empty() || turned_.front().empty()) return {};
    std::priority_queue<Node, std::vector<Node>, IsOpenedLater> open;
    push_roots(open);
    std::vector<WiderStart> found;
    for (std::size_t opened = 0; !open.empty() && opened < kMostOpened; ++opened) {
      const Node node = open.top();
      open.pop();
      if (is_known(node, found)) continue;
      if (node.level > 0) {
        push_children(node, open);
        continue;
      }
      found.push_back(start_of(node));
      if (found.size() == options_.most_starts) break;
    }
    return found;
  }

 private:
  using Queue = std::priority_queue<Node, std::vector<Node>, IsOpenedLater>;

  [[nodiscard]] const Eigen::Matrix3d& rotation_of(int heading) const {
    return rotations_[static_cast<std::size_t>(heading)];
  }

  // The scan's cells at every heading.
  void turn(const std::vector<Eigen::Vector3d>& scan_upright_m) {
    std::vector<Eigen::Vector3d> levelled_m;
    for (const Eigen::Vector3d& point_m : scan_upright_m) {
      levelled_m.push_back(T_map_around_.linear() * point_m);
    }
    levelled_m = thinned_in_plane(levelled_m, options_.most_points);
    for (const Eigen::Matrix3d& rotation : rotations_) {
      std::vector<ScanCell>& cells = turned_.emplace_back();
      for (const Eigen::Vector3d& point_m : levelled_m) {
        const Eigen::Vector3d turned_m = rotation * point_m;
        cells.push_back({pyramid_.row(floor_to_int(turned_m.y() / kCell_m)) +
                             floor_to_int(turned_m.x() / kCell_m),
                         layer_of(turned_m.z())});
      }
    }
  }

  // Of all places within reach, in squares of which each is the quarter of another.
  void push_roots(Queue& open) const {
    for (int heading = 0; heading < options_.headings; ++heading) {
      for (int x = -reach_; x <= reach_; x += 1 << kLevels) {
        for (int y = -reach_; y <= reach_; y += 1 << kLevels) {
          push_children({0, kLevels, heading, {x, y}}, open);
        }
      }
    }
  }

  void push_children(const Node& node, Queue& open) const {
    const std::vector<ScanCell>& cells = turned_[static_cast<std::size_t>(node.heading)];
    const std::uint32_t* quarters =
        pyramid_.quarters(node.level).data() + pyramid_.place_of(node.place.x, node.place.y);
    std::uint32_t bounds = 0;  // a byte for each quarter
    for (const ScanCell& cell : cells) {
      bounds += quarters[cell.offset] >> cell.layer & 0x01010101U;
    }
    const double least = options_.least_share * static_cast<double>(cells.size());
    const int half = 1 << (node.level - 1);
    for (const int y : {0, half}) {
      for (const int x : {0, half}) {
        const unsigned bound = bounds & 0xffU;
        bounds >>= 8;
        const Offset place{node.place.x + x, node.place.y + y};
        if (place.x > reach_ || place.y > reach_ || bound < least) continue;
        open.push({bound, node.level - 1, node.heading, place});
      }
    }
  }

  [[nodiscard]] WiderStart start_of(const Node& node) const {
    WiderStart start;
    start.T_map_lidar.linear() = rotation_of(node.heading) * T_map_around_.linear();
    start.T_map_lidar.translation() =
        T_map_around_.translation() +
        Eigen::Vector3d(node.place.x * kCell_m, node.place.y * kCell_m, 0.0);
    start.share = node.bound / static_cast<double>(turned_.front().size());
    return start;
  }

  // Whether every place of the node is next to a better start.
  bool is_known(const Node& node, const std::vector<WiderStart>& found) const {
    if (found.empty()) return false;
    const double side_m = kCell_m * ((1 << node.level) - 1);
    const Eigen::Vector2d middle_m(kCell_m * node.place.x + 0.5 * side_m,
                                   kCell_m * node.place.y + 0.5 * side_m);
    const double reach_m = std::sqrt(0.5) * side_m;
    const Eigen::Matrix3d rotation = rotation_of(node.heading) * T_map_around_.linear();
    return std::ranges::any_of(found, [&](const WiderStart& better) {
      const Eigen::Vector3d off_m = better.T_map_lidar.translation() - T_map_around_.translation();
      return (off_m.head<2>() - middle_m).norm() + reach_m < kDistinct_m &&
             rotation_angle_rad(better.T_map_lidar.linear().transpose() * rotation) < kDistinct_rad;
    });
  }

  Pose T_map_around_;
  WideSearch options_;
  int reach_;
  Pyramid pyramid_;
  std::vector<Eigen::Matrix3d> rotations_;     // by heading
  std::vector<std::vector<ScanCell>> turned_;  // by heading
};

}  // namespace

std::vector<WiderStart> wider_starts(const std::vector<Eigen::Vector3d>& map_upright_m,
                                     const std::vector<Eigen::Vector3d>& scan_upright_m,
                                     const Pose& T_map_around, const WideSearch& options) {
  return Search(map_upright_m, T_map_around, options).best(scan_upright_m);
}

}  // namespace sightline
