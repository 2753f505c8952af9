#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "formats/base/random.h"
#include "formats/drive/recording_cards.h"

// Scans of a street of house fronts, by rays with noise, and what people do to copies of them.

namespace sightline {

using ScanPoints = std::vector<Eigen::Vector3d>;

struct StreetDrive {
  std::uint64_t street = 1;
  std::uint64_t noise = 1;  // another drive has another one
  double lateral_m = 0.0;
  double sigma_m = 0.02;
};

// How far the front of a house is from the middle of the street.
inline double front_m(std::uint64_t street, double x_m, bool is_left) {
  const auto house = static_cast<std::uint64_t>(std::floor(x_m / 3.0) + 1000.0);
  return 7.0 + 6.0 * Random(mix(street, 2 * house + (is_left ? 1 : 0))).uniform();
}

// From the middle of the street at x_m.
inline ScanPoints street_scan(const StreetDrive& drive, double x_m) {
  constexpr int kRings = 12;
  constexpr int kSteps = 250;
  constexpr double kHeight_m = 1.8;
  Random noise(mix(drive.noise, static_cast<std::uint64_t>(std::llround(1000.0 * x_m))));
  ScanPoints points_m;
  for (int step = 0; step < kSteps; ++step) {
    const double azimuth = 2.0 * std::numbers::pi * (step + 0.5) / kSteps;
    for (int ring = 0; ring < kRings; ++ring) {
      const double elevation = -0.3 + 0.04 * ring;
      const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                                std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
      double range_m = ray.z() < 0.0 ? -kHeight_m / ray.z() : 1e3;
      for (double along_m = 2.0; along_m < std::min(range_m, 60.0); along_m += 0.5) {
        const double y_m = drive.lateral_m + along_m * ray.y();
        const double front = front_m(drive.street, x_m + along_m * ray.x(), y_m > 0.0);
        if (std::abs(y_m) < front) continue;
        range_m = std::min(range_m, along_m - (std::abs(y_m) - front) / std::abs(ray.y()));
        break;
      }
      if (range_m > 60.0) continue;
      points_m.push_back((range_m + drive.sigma_m * noise.normal()) * ray);
    }
  }
  return points_m;
}

// `count` scans a metre apart.
inline std::vector<ScanPoints> street_scans(const StreetDrive& drive, int first, int count) {
  std::vector<ScanPoints> scans;
  for (int i = first; i < first + count; ++i) scans.push_back(street_scan(drive, i));
  return scans;
}

inline ScanPoints with_noise(ScanPoints points_m, double sigma_m, std::uint64_t seed) {
  Random noise(seed);
  for (Eigen::Vector3d& point_m : points_m) {
    for (int axis = 0; axis < 3; ++axis) point_m[axis] += sigma_m * noise.normal();
  }
  return points_m;
}

inline ScanPoints in_millimetres(ScanPoints points_m) {
  for (Eigen::Vector3d& point_m : points_m) {
    for (int axis = 0; axis < 3; ++axis) point_m[axis] = std::round(1e3 * point_m[axis]) / 1e3;
  }
  return points_m;
}

inline ScanPoints in_float(ScanPoints points_m) {
  for (Eigen::Vector3d& point_m : points_m) point_m = point_m.cast<float>().cast<double>();
  return points_m;
}

inline ScanPoints thinned(const ScanPoints& points_m, double share, std::uint64_t seed) {
  Random chance(seed);
  ScanPoints kept;
  for (const Eigen::Vector3d& point_m : points_m) {
    if (chance.uniform() < share) kept.push_back(point_m);
  }
  return kept;
}

inline ScanPoints cropped(ScanPoints points_m, double range_m) {
  std::erase_if(points_m, [&](const Eigen::Vector3d& point_m) { return point_m.norm() > range_m; });
  return points_m;
}

inline RecordingCard card_of(const std::string& name, const std::vector<ScanPoints>& scans) {
  RecordingCard card{"mapping", name, sha256(name)};
  for (const ScanPoints& scan : scans) card.scans.push_back(sketch_of(scan));
  return card;
}

}  // namespace sightline
