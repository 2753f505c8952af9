#include "passes/replay/place_finder.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "formats/base/parallel.h"
#include "formats/grid/cell_key.h"
#include "passes/trajectory/local/wider_starts.h"
#include "passes/trajectory/met_share.h"

// A scan's upright points are compared with points on the map's walls and poles by branch and
// bound, stretch by stretch of the route: first for the best pose of each, by which the searches
// for all poses that are nearly as good leave out most of the map.

namespace sightline {
namespace {

// Every position of the route is within this of the middle of a stretch, along both axes.
constexpr double kStretch_m = 20.0;
// A vehicle is so far beside the route at most.
constexpr double kBeside_m = 5.0;
constexpr double kStorey_m = 1.5;
// As far as points of a scan are compared (wider_starts), and a cell.
constexpr double kScanReach_m = 42.0;
constexpr double kBlock_m = 32.0;
// Less is met by chance in many streets.
constexpr double kLeastShare = 0.15;
// Shares count points in cells of 0.5 m: the right place may be so much worse than the best one.
constexpr double kWorse = 0.15;
// Along a wall every pose meets it: so many of a stretch.
constexpr std::size_t kMostOfStretch = 24;
constexpr std::size_t kMostPlaces = 400;
// Stretches that are searched at once; the largest share so far shortens the next ones.
constexpr std::size_t kGroup = 8;
// Half of both costs a quarter of the time, and the matches that follow correct the rest.
constexpr int kHeadings = 180;
constexpr std::size_t kPoints = 120;
// Between points on the surface of an ND.
constexpr double kSpacing_m = 0.4;
constexpr double kSigmas = 1.6;  // the edge of an evenly covered surface is at 1.73

int block_of(double coordinate_m) { return floor_to_int(coordinate_m / kBlock_m); }

int steps_of(double sigma_m) { return static_cast<int>(kSigmas * sigma_m / kSpacing_m); }

// Points on the surface or the line of an ND.
void add_points(const Nd& nd, std::vector<Eigen::Vector3d>& points_m) {
  const int longer = steps_of(std::sqrt(nd.eigenvalues_m2[0]));
  const int shorter = steps_of(std::sqrt(nd.eigenvalues_m2[1]));
  for (int i = -longer; i <= longer; ++i) {
    for (int j = -shorter; j <= shorter; ++j) {
      points_m.emplace_back(nd.mean_m + kSpacing_m * i * nd.eigenvectors.col(0) +
                            kSpacing_m * j * nd.eigenvectors.col(1));
    }
  }
}

bool is_near(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m) {
  return (a_m - b_m).head<2>().cwiseAbs().maxCoeff() < kStretch_m &&
         std::abs(a_m.z() - b_m.z()) < kStorey_m;
}

}  // namespace

PlaceFinder::PlaceFinder(const NdtMap& map, std::span<const Eigen::Vector3d> route_world_m,
                         const Pose& T_vehicle_sensor)
    : frame_(map.frame) {
  for (const Eigen::Vector3d& position_world_m : route_world_m) {
    Eigen::Vector3d at_m = position_world_m - frame_.origin_world_m;
    at_m.z() -= T_vehicle_sensor.translation().z();
    const auto is_covered = [&](const Eigen::Vector3d& middle_m) {
      return is_near(at_m, middle_m);
    };
    if (std::ranges::none_of(middles_m_, is_covered)) middles_m_.push_back(at_m);
  }
  for (const Nd& nd : map.nds) {
    if (!identifies_place(nd)) continue;
    add_points(nd, upright_m_[{block_of(nd.mean_m.x()), block_of(nd.mean_m.y())}]);
  }
}

std::vector<Eigen::Vector3d> PlaceFinder::map_points_around(const Eigen::Vector3d& at_m) const {
  constexpr double kReach_m = kStretch_m + kBeside_m + kScanReach_m;
  std::vector<Eigen::Vector3d> points_m;
  for (int x = block_of(at_m.x() - kReach_m); x <= block_of(at_m.x() + kReach_m); ++x) {
    for (int y = block_of(at_m.y() - kReach_m); y <= block_of(at_m.y() + kReach_m); ++y) {
      const auto block = upright_m_.find({x, y});
      if (block == upright_m_.end()) continue;
      points_m.insert(points_m.end(), block->second.begin(), block->second.end());
    }
  }
  return points_m;
}

std::vector<WiderStart> PlaceFinder::starts_of(const std::vector<Eigen::Vector3d>& upright_m,
                                               const WideSearch& search, std::size_t first,
                                               int threads) const {
  const std::size_t count = std::min(kGroup, middles_m_.size() - first);
  const auto search_one = [&](std::size_t i) {
    const Eigen::Vector3d& middle_m = middles_m_[first + i];
    return wider_starts(map_points_around(middle_m), upright_m,
                        Pose(Eigen::Translation3d(middle_m)), search);
  };
  std::vector<WiderStart> all;
  for (const std::vector<WiderStart>& starts :
       parallel_map<std::vector<WiderStart>>(count, threads, search_one)) {
    all.insert(all.end(), starts.begin(), starts.end());
  }
  return all;
}

// The largest share, then all that are nearly as large: a search for one alone is short, and a
// search that knows what is too small is too.
std::vector<Pose> PlaceFinder::likely_places(const std::vector<Eigen::Vector3d>& upright_m,
                                             int threads) const {
  WideSearch search{kStretch_m + kBeside_m, kLeastShare, 1, kHeadings, kPoints};
  for (std::size_t first = 0; first < middles_m_.size(); first += kGroup) {
    for (const WiderStart& best : starts_of(upright_m, search, first, threads)) {
      search.least_share = std::max(search.least_share, best.share);
    }
  }
  search.least_share = std::max(kLeastShare, search.least_share - kWorse);
  search.most_starts = kMostOfStretch;
  std::vector<WiderStart> likely;
  for (std::size_t first = 0; first < middles_m_.size(); first += kGroup) {
    const std::vector<WiderStart> starts = starts_of(upright_m, search, first, threads);
    likely.insert(likely.end(), starts.begin(), starts.end());
  }
  std::ranges::stable_sort(likely, std::greater(), &WiderStart::share);
  if (likely.size() > kMostPlaces) likely.resize(kMostPlaces);
  std::vector<Pose> places;
  places.reserve(likely.size());
  for (const WiderStart& start : likely) {
    places.push_back(rebase(start.T_map_lidar, frame_, MapFrame{}));
  }
  return places;
}

}  // namespace sightline
