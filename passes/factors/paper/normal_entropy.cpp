#include "passes/factors/paper/normal_entropy.h"

#include <array>
#include <cmath>
#include <numbers>

#include "formats/base/portable_math.h"
#include "passes/factors/paper/entropy.h"

namespace sightline {
namespace {

constexpr int kSectors = 18;
constexpr int kBands = 4;
// On a sphere area goes with height: the cap of one bin is 1/73 of the upper half high, and each
// band of 18 bins 18/73.
constexpr double kCapBegin = 72.0 / 73.0;
constexpr double kBandHeight = 18.0 / 73.0;

int sector_of(double azimuth_deg, double width_deg) {
  const int sector = static_cast<int>(std::floor((azimuth_deg + width_deg / 2.0) / width_deg));
  return sector % kSectors;
}

}  // namespace

int normal_bin(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d up = normal.z() < 0.0 ? Eigen::Vector3d(-normal) : normal;
  if (up.z() >= kCapBegin) return 0;
  const int band = std::min(static_cast<int>(up.z() / kBandHeight), kBands - 1);
  double azimuth_deg = portable_atan2(up.y(), up.x()) * 180.0 / std::numbers::pi;
  if (azimuth_deg < 0.0) azimuth_deg += 360.0;
  // On the rim n and -n are both up: there 18 sectors of 10 degrees go round twice.
  const int sector = sector_of(azimuth_deg, band == 0 ? 10.0 : 20.0);
  return 1 + kSectors * band + sector;
}

std::vector<double> normal_entropy(const Vicinity& vicinity, std::span<const int> normal_bin_of) {
  std::vector<double> entropy;
  std::array<double, kNormalBinCount> histogram{};
  double total = 0.0;
  for (std::size_t range = 0; range < vicinity.ranges_m.size(); ++range) {
    for (std::size_t i = vicinity.shell_begin(range); i < vicinity.end[range]; ++i) {
      const int bin = normal_bin_of[vicinity.nd_index[i]];
      if (bin < 0) continue;
      histogram[static_cast<std::size_t>(bin)] += 1.0;
      total += 1.0;
    }
    entropy.push_back(entropy_bits(histogram, total));
  }
  return entropy;
}

}  // namespace sightline
