#include "formats/drive/identity/scan_sketch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr double kCell_m = 0.02;
// Coordinates in whole millimetres lie in the middle between the borders of cells.
constexpr double kHalfMillimetre_m = 0.0005;
constexpr double kNearest_m = 4.0;  // nearer returns are of the vehicle itself, in every scan alike
// Odd and large, so that neighbouring cells have sums far apart.
constexpr std::uint64_t kOddX = 0x9e3779b97f4a7c15;
constexpr std::uint64_t kOddY = 0xc2b2ae3d27d4eb4f;
constexpr std::uint64_t kOddZ = 0x165667b19e3779f9;

std::uint64_t cell_number(double coordinate_m) {
  return static_cast<std::uint64_t>(
      static_cast<std::int64_t>(std::floor((coordinate_m + kHalfMillimetre_m) / kCell_m)));
}

std::uint64_t cell_hash(const Eigen::Vector3d& point_m) {
  const std::uint64_t cell = kOddX * cell_number(point_m.x()) + kOddY * cell_number(point_m.y()) +
                             kOddZ * cell_number(point_m.z());
  return Random(cell).next();
}

// Five bits for the leading zeros, eleven for what follows the first one: in the order of the
// hashes, with an error of 1/2048.
std::uint16_t rounded(std::uint64_t hash) {
  constexpr int kMostZeros = 30;  // 2^30 cells and more would be needed for a lesser hash
  const int zeros = std::min(std::countl_zero(hash), kMostZeros);
  const std::uint64_t behind = (hash << (zeros + 1)) >> 53U;
  const std::uint64_t order = ((31U - static_cast<unsigned>(zeros)) << 11U) | behind;
  return static_cast<std::uint16_t>(std::min<std::uint64_t>(order, kNoHash - 1));
}

// Ascending, each once.
void keep_least(std::uint64_t hash, std::vector<std::uint64_t>& least) {
  if (least.size() == kSketchSize && hash >= least.back()) return;
  const auto place = std::ranges::lower_bound(least, hash);
  if (place != least.end() && *place == hash) return;
  least.insert(place, hash);
  if (least.size() > kSketchSize) least.pop_back();
}

std::size_t count_up_to(const ScanSketch& sketch, std::uint16_t greatest) {
  return static_cast<std::size_t>(std::ranges::upper_bound(sketch, greatest) - sketch.begin());
}

std::size_t count_common(std::span<const std::uint16_t> a, std::span<const std::uint16_t> b) {
  std::size_t common = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i] == b[j]) {
      ++common, ++i, ++j;
    } else {
      a[i] < b[j] ? ++i : ++j;
    }
  }
  return common;
}

}  // namespace

ScanSketch sketch_of(std::span<const Eigen::Vector3d> points_m) {
  std::vector<std::uint64_t> least;
  least.reserve(kSketchSize + 1);
  for (const Eigen::Vector3d& point_m : points_m) {
    if (point_m.squaredNorm() < kNearest_m * kNearest_m) continue;
    keep_least(cell_hash(point_m), least);
  }
  ScanSketch sketch;
  sketch.fill(kNoHash);
  std::ranges::transform(least, sketch.begin(), rounded);
  return sketch;
}

double likeness(const ScanSketch& a, const ScanSketch& b) {
  constexpr std::size_t kFewest = 4;
  const std::uint16_t greatest =
      std::min({a.back(), b.back(), static_cast<std::uint16_t>(kNoHash - 1)});
  const std::size_t of_a = count_up_to(a, greatest);
  const std::size_t of_b = count_up_to(b, greatest);
  const std::size_t fewer = std::min(of_a, of_b);
  if (fewer < kFewest) return 0.0;
  return static_cast<double>(count_common(std::span(a).first(of_a), std::span(b).first(of_b))) /
         static_cast<double>(fewer);
}

}  // namespace sightline
