#include "tests/support/toy_world.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr double kLattice_m = 0.1;
constexpr int kPerSquare = 10;
constexpr int kPerHeight = 40;
constexpr double kSensorHeight_m = 1.8;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::string line;
  for (const char c : text) {
    if (c != '\n') {
      line += c;
    } else {
      lines.push_back(std::move(line));
      line.clear();
    }
  }
  if (!line.empty()) lines.push_back(std::move(line));
  // A drawing may begin on the line after the opening quote.
  if (!lines.empty() && lines.front().empty()) lines.erase(lines.begin());
  return lines;
}

class Plan {
 public:
  explicit Plan(std::string_view text) : lines_(lines_of(text)) {
    std::reverse(lines_.begin(), lines_.end());
  }
  [[nodiscard]] int height() const { return static_cast<int>(lines_.size()); }
  [[nodiscard]] int width(int y) const {
    return static_cast<int>(lines_[static_cast<std::size_t>(y)].size());
  }
  [[nodiscard]] char at(int x, int y) const {
    if (y < 0 || y >= height() || x < 0 || x >= width(y)) return ' ';
    return lines_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
  }

 private:
  std::vector<std::string> lines_;
};

// The middle of the i-th step of the lattice.
double step_m(int i) { return (i + 0.5) * kLattice_m; }

void draw_ground(double x, double y, std::vector<Eigen::Vector3d>& points_m) {
  for (int i = 0; i < kPerSquare; ++i) {
    for (int j = 0; j < kPerSquare; ++j) points_m.emplace_back(x + step_m(i), y + step_m(j), 0.0);
  }
}

void draw_pole(double x, double y, std::vector<Eigen::Vector3d>& points_m) {
  constexpr double kRadius_m = 0.1;
  constexpr int kAround = 8;
  for (int k = 0; k < kPerHeight; ++k) {
    for (int i = 0; i < kAround; ++i) {
      const double angle_rad = 2.0 * std::numbers::pi * i / kAround;
      points_m.emplace_back(x + 0.5 + kRadius_m * std::cos(angle_rad),
                            y + 0.5 + kRadius_m * std::sin(angle_rad), step_m(k));
    }
  }
}

void draw_block(const Plan& plan, int x, int y, std::vector<Eigen::Vector3d>& points_m) {
  for (int k = 0; k < kPerHeight; ++k) {
    for (int i = 0; i < kPerSquare; ++i) {
      const double along_m = step_m(i);
      if (plan.at(x - 1, y) != '#') points_m.emplace_back(x, y + along_m, step_m(k));
      if (plan.at(x + 1, y) != '#') points_m.emplace_back(x + 1, y + along_m, step_m(k));
      if (plan.at(x, y - 1) != '#') points_m.emplace_back(x + along_m, y, step_m(k));
      if (plan.at(x, y + 1) != '#') points_m.emplace_back(x + along_m, y + 1, step_m(k));
    }
  }
}

void draw_square(const Plan& plan, int x, int y, std::vector<Eigen::Vector3d>& points_m) {
  const char kind = plan.at(x, y);
  if (kind == '.' || kind == 'o' || kind == '@') draw_ground(x, y, points_m);
  if (kind == 'o') draw_pole(x, y, points_m);
  if (kind == '#') draw_block(plan, x, y, points_m);
}

void add_site(int x, int y, Sites& sites) {
  Site site;
  site.s_m = static_cast<double>(sites.sites.size());
  site.p_map_m = {x + 0.5, y + 0.5, kSensorHeight_m};
  site.T_map_vehicle.translation() = site.p_map_m;
  sites.sites.push_back(site);
}

Nd random_nd(Random& random, const CellKey& key, double cell_m) {
  Nd nd;
  nd.key = key;
  nd.point_count = static_cast<std::uint32_t>(10 + random.below(200));
  const Eigen::Vector3d corner_m = cell_m * Eigen::Vector3d(key.x, key.y, key.z);
  for (int i = 0; i < 3; ++i) nd.mean_m[i] = corner_m[i] + random.uniform(0.05, 0.95) * cell_m;
  Eigen::Matrix3d spread;
  for (int i = 0; i < 9; ++i) spread(i % 3, i / 3) = random.normal();
  // Long, flat and round ones alike.
  const Eigen::Vector3d scale_m(0.3 * cell_m, 0.3 * cell_m * random.uniform(),
                                0.1 * cell_m * random.uniform());
  const Eigen::Matrix3d root = 0.4 * spread * scale_m.asDiagonal();
  const Eigen::Matrix3d covariance = root * root.transpose();
  nd.covariance_m2 = 0.5 * (covariance + covariance.transpose());
  decompose(nd);
  return nd;
}

}  // namespace

ToyWorld draw_world(std::string_view text) {
  const Plan plan(text);
  ToyWorld world;
  for (int y = plan.height() - 1; y >= 0; --y) {
    for (int x = 0; x < plan.width(y); ++x) {
      draw_square(plan, x, y, world.points.points_m);
      if (plan.at(x, y) == '@') add_site(x, y, world.sites);
    }
  }
  return world;
}

NdtMap random_ndt_map(std::uint64_t seed, int count, double half_extent_m, double cell_m,
                      double tile_m) {
  constexpr double kHalfHeight_m = 3.0;
  Random random(seed);
  std::map<std::pair<TileKey, CellKey>, Nd> nds;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d place_m(random.uniform(-half_extent_m, half_extent_m),
                                  random.uniform(-half_extent_m, half_extent_m),
                                  random.uniform(-kHalfHeight_m, kHalfHeight_m));
    const CellKey key = cell_key(place_m, cell_m);
    nds[{tile_of(key, cell_m, tile_m), key}] = random_nd(random, key, cell_m);
  }
  NdtMap map;
  map.cell_m = cell_m;
  map.tile_m = tile_m;
  for (const auto& [order, nd] : nds) {
    map.point_count += nd.point_count;
    map.nds.push_back(nd);
  }
  return map;
}

}  // namespace sightline
