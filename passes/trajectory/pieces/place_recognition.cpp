#include "passes/trajectory/pieces/place_recognition.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// A place has the keys of one scan in so much of the way, within so much of its middle.
constexpr double kKeyEvery_m = 5.0;
constexpr double kKeyReach_m = 15.0;

Result<PlaceKey> key_of(const Drive& drive, std::uint32_t scan) {
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, scan, ThinnedFor::kMatch));
  return place_key(upright_points(thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear()));
}

constexpr double kRing_m = 2.0;
constexpr std::size_t kDirections = 60;

}  // namespace

Result<std::vector<std::uint32_t>> PlaceRecognition::before(std::uint32_t later,
                                                            const std::vector<Query>& queries) {
  std::vector<PlaceKey> wanted;
  for (const Query& query : queries) wanted.push_back(place_key(query.upright_m));
  std::vector<std::pair<double, std::uint32_t>> places;
  for (std::uint32_t piece = later; piece-- > 0;) {
    SIGHTLINE_TRY(read_keys(piece));
    for (const std::uint32_t middle : middles_of(odometry_, pieces_[piece])) {
      places.emplace_back(least_difference(piece, middle, wanted), middle);
    }
  }
  std::ranges::stable_sort(places, {}, &std::pair<double, std::uint32_t>::first);
  std::vector<std::uint32_t> middles;
  for (const auto& [difference, middle] : places) middles.push_back(middle);
  return middles;
}

Result<void> PlaceRecognition::read_keys(std::uint32_t piece) {
  if (!keys_[piece].empty()) return {};
  const std::vector<std::uint32_t> scans = scans_every(odometry_, pieces_[piece], kKeyEvery_m);
  SIGHTLINE_ASSIGN(const std::vector<PlaceKey> keys,
                   parallel_results<PlaceKey>(scans.size(), ctx_.threads, [&](std::size_t i) {
                     return key_of(drive_, scans[i]);
                   }));
  for (std::size_t i = 0; i < scans.size(); ++i) keys_[piece].emplace_back(scans[i], keys[i]);
  return {};
}

double PlaceRecognition::least_difference(std::uint32_t piece, std::uint32_t middle,
                                          const std::vector<PlaceKey>& wanted) const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [scan, key] : keys_[piece]) {
    if (std::abs(odometry_.driven_m[scan] - odometry_.driven_m[middle]) > kKeyReach_m) continue;
    for (const PlaceKey& one : wanted) least = std::min(least, difference(one, key));
  }
  return least;
}

PlaceKey place_key(const std::vector<Eigen::Vector3d>& upright_m) {
  std::array<std::bitset<kDirections>, std::tuple_size_v<PlaceKey>> rings;
  for (const Eigen::Vector3d& point_m : upright_m) {
    const auto ring = static_cast<std::size_t>(point_m.head<2>().norm() / kRing_m);
    if (ring >= rings.size()) continue;
    const double turns = portable_atan2(point_m.y(), point_m.x()) / (2.0 * std::numbers::pi) + 0.5;
    rings[ring].set(std::min(static_cast<std::size_t>(turns * kDirections), kDirections - 1));
  }
  PlaceKey key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<float>(rings[i].count());
  return key;
}

double difference(const PlaceKey& a, const PlaceKey& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

}  // namespace sightline
