#include "passes/trajectory/pieces/place_key.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <tuple>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kRing_m = 2.0;
constexpr std::size_t kDirections = 60;

}  // namespace

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
