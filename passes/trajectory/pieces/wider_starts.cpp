#include "passes/trajectory/pieces/wider_starts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <queue>

#include "formats/grid/cell_key.h"
#include "formats/grid/flat_cell_map.h"
#include "formats/rotation.h"

// Branch and bound over heading and place. A node is a heading and a square of places; its bound
// counts the scan's points that meet a cell of the map anywhere in the square, which a pyramid of
// grids answers with one look a point. The best node is opened first, so the first squares of one
// cell that come out are the best there are.

namespace sightline {
namespace {

constexpr double kCell_m = 0.5;
// Half a cell at the end of the farthest point.
constexpr int kHeadings = 504;
constexpr double kScanReach_m = 40.0;
constexpr int kLevels = 6;  // squares of 1 to 32 cells
// Thinned to so many: enough to tell places apart.
constexpr std::size_t kMostPoints = 240;
constexpr std::size_t kMostStarts = 8;
constexpr std::size_t kMostOpened = 200'000;
constexpr double kDistinct_m = 1.5;
constexpr double kDistinct_rad = 10.0 * std::numbers::pi / 180.0;

struct Offset {
  std::int32_t x = 0;
  std::int32_t y = 0;
};

struct ScanCell {
  Offset place;
  unsigned layer_bit = 0;
};

// Heights are told in layers, one bit each, from this far below the sensor; what is lower or higher
// counts to the first or last.
constexpr int kLayers = 8;
constexpr double kLayer_m = 1.0;
constexpr double kLowest_m = -3.0;

unsigned layer_bit(double off_m) {
  const int layer = floor_to_int((off_m - kLowest_m) / kLayer_m);
  return 1U << std::clamp(layer, 0, kLayers - 1);
}

// level(h) at (x, y): in which layers the map has a cell in the square of 2^h cells that begins
// there.
class Pyramid {
 public:
  // Cells from -half to half along both axes.
  Pyramid(const std::vector<Eigen::Vector3d>& points_m, const Eigen::Vector3d& middle_m, int half)
      : half_(half), size_(2 * half + 1) {
    levels_.assign(kLevels, std::vector<std::uint8_t>(static_cast<std::size_t>(size_ * size_), 0));
    for (const Eigen::Vector3d& point_m : points_m) mark(point_m - middle_m);
    for (int h = 1; h < kLevels; ++h) pool(h);
  }
  [[nodiscard]] unsigned at(int h, std::int32_t x, std::int32_t y) const {
    // A square that begins before the grid may reach into it.
    x = std::max(x, x + (1 << h) > -half_ ? -half_ : x);
    y = std::max(y, y + (1 << h) > -half_ ? -half_ : y);
    if (x < -half_ || y < -half_ || x > half_ || y > half_) return 0;
    return levels_[static_cast<std::size_t>(h)][index(x + half_, y + half_)];
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y * size_ + x);
  }
  // A point counts for the cells and layers within half a cell, half a layer of it.
  void mark(const Eigen::Vector3d& off_m) {
    const double half_layer_m = 0.5 * kLayer_m;
    const unsigned bits = layer_bit(off_m.z() - half_layer_m) | layer_bit(off_m.z() + half_layer_m);
    for (const double dx : {-0.25, 0.25}) {
      for (const double dy : {-0.25, 0.25}) {
        const int x = floor_to_int(off_m.x() / kCell_m + dx) + half_;
        const int y = floor_to_int(off_m.y() / kCell_m + dy) + half_;
        if (x < 0 || y < 0 || x >= size_ || y >= size_) continue;
        std::uint8_t& cell = levels_[0][index(x, y)];
        cell = static_cast<std::uint8_t>(cell | bits);
      }
    }
  }
  void pool(int h) {
    const std::vector<std::uint8_t>& finer = levels_[static_cast<std::size_t>(h - 1)];
    std::vector<std::uint8_t>& coarser = levels_[static_cast<std::size_t>(h)];
    const int half_square = 1 << (h - 1);
    for (int y = 0; y < size_; ++y) {
      for (int x = 0; x < size_; ++x) {
        unsigned any = finer[index(x, y)];
        const bool has_right = x + half_square < size_;
        const bool has_above = y + half_square < size_;
        if (has_right) any |= finer[index(x + half_square, y)];
        if (has_above) any |= finer[index(x, y + half_square)];
        if (has_right && has_above) any |= finer[index(x + half_square, y + half_square)];
        coarser[index(x, y)] = static_cast<std::uint8_t>(any);
      }
    }
  }

  int half_;
  int size_;
  std::vector<std::vector<std::uint8_t>> levels_;
};

struct Node {
  int bound = 0;
  int level = 0;
  int heading = 0;
  Offset place;
};

// The order in which nodes are opened; smaller squares first, then ties by place.
struct IsOpenedLater {
  bool operator()(const Node& a, const Node& b) const {
    const auto order = [](const Node& n) {
      return std::array<int, 5>{n.bound, -n.level, -n.heading, -n.place.x, -n.place.y};
    };
    return order(a) < order(b);
  }
};

// One point in a cell, as many as are needed, evenly over the list.
std::vector<Eigen::Vector3d> thinned_in_plane(const std::vector<Eigen::Vector3d>& points_m) {
  FlatCellMap<std::uint8_t> cells;
  std::vector<Eigen::Vector3d> kept_m;
  for (const Eigen::Vector3d& point_m : points_m) {
    if (point_m.head<2>().norm() > kScanReach_m) continue;
    const CellKey key{floor_to_int(point_m.x() / kCell_m), floor_to_int(point_m.y() / kCell_m),
                      floor_to_int(point_m.z() / kLayer_m)};
    if (cells.insert(key).is_new) kept_m.push_back(point_m);
  }
  if (kept_m.size() <= kMostPoints) return kept_m;
  std::vector<Eigen::Vector3d> few_m;
  for (std::size_t i = 0; i < kMostPoints; ++i) {
    few_m.push_back(kept_m[i * kept_m.size() / kMostPoints]);
  }
  return few_m;
}

class Search {
 public:
  Search(const std::vector<Eigen::Vector3d>& map_upright_m, const Pose& T_map_around,
         const WideSearch& options)
      : T_map_around_(T_map_around),
        least_share_(options.least_share),
        reach_(static_cast<int>(std::ceil(options.reach_m / kCell_m))),
        pyramid_(map_upright_m, T_map_around.translation(),
                 reach_ + static_cast<int>(kScanReach_m / kCell_m) + 2) {}

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
      if (found.size() == kMostStarts) break;
    }
    return found;
  }

 private:
  using Queue = std::priority_queue<Node, std::vector<Node>, IsOpenedLater>;

  static Eigen::Matrix3d rotation_of(int heading) {
    return rotation_matrix(
        {Eigen::Vector3d::UnitZ(), 2.0 * std::numbers::pi * heading / kHeadings});
  }

  // The scan's cells at every heading.
  void turn(const std::vector<Eigen::Vector3d>& scan_upright_m) {
    std::vector<Eigen::Vector3d> levelled_m;
    for (const Eigen::Vector3d& point_m : scan_upright_m) {
      levelled_m.push_back(T_map_around_.linear() * point_m);
    }
    levelled_m = thinned_in_plane(levelled_m);
    for (int heading = 0; heading < kHeadings; ++heading) {
      const Eigen::Matrix3d rotation = rotation_of(heading);
      std::vector<ScanCell>& cells = turned_.emplace_back();
      for (const Eigen::Vector3d& point_m : levelled_m) {
        const Eigen::Vector3d turned_m = rotation * point_m;
        cells.push_back(
            {{floor_to_int(turned_m.x() / kCell_m), floor_to_int(turned_m.y() / kCell_m)},
             layer_bit(turned_m.z())});
      }
    }
  }

  void push(Node node, Queue& open) const {
    for (const ScanCell& cell : turned_[static_cast<std::size_t>(node.heading)]) {
      const unsigned layers =
          pyramid_.at(node.level, cell.place.x + node.place.x, cell.place.y + node.place.y);
      if ((layers & cell.layer_bit) != 0) ++node.bound;
    }
    const double least = least_share_ * static_cast<double>(turned_.front().size());
    if (node.bound >= least) open.push(node);
  }

  void push_roots(Queue& open) const {
    constexpr int kRoot = kLevels - 1;
    for (int heading = 0; heading < kHeadings; ++heading) {
      for (int x = -reach_; x <= reach_; x += 1 << kRoot) {
        for (int y = -reach_; y <= reach_; y += 1 << kRoot) {
          push({0, kRoot, heading, {x, y}}, open);
        }
      }
    }
  }

  void push_children(const Node& node, Queue& open) const {
    const int half = 1 << (node.level - 1);
    for (const int x : {0, half}) {
      for (const int y : {0, half}) {
        const Offset place{node.place.x + x, node.place.y + y};
        if (place.x > reach_ || place.y > reach_) continue;
        push({0, node.level - 1, node.heading, place}, open);
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

  // Whether all that the node holds is next to a better start.
  bool is_known(const Node& node, const std::vector<WiderStart>& found) const {
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
  double least_share_;
  int reach_;
  Pyramid pyramid_;
  std::vector<std::vector<ScanCell>> turned_;
};

}  // namespace

std::vector<WiderStart> wider_starts(const std::vector<Eigen::Vector3d>& map_upright_m,
                                     const std::vector<Eigen::Vector3d>& scan_upright_m,
                                     const Pose& T_map_around, const WideSearch& options) {
  return Search(map_upright_m, T_map_around, options).best(scan_upright_m);
}

}  // namespace sightline
