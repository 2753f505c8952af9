#include "tests/bench/integrity/faults.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "passes/matching/covariance/protection.h"
#include "tests/bench/integrity/protection_samples.h"

namespace sightline {
namespace {

constexpr double kPulls_m[] = {0.5, 1.0, 2.0, 5.0};
constexpr std::size_t kEvery = 30;
constexpr std::size_t kScans = 10;
constexpr double kFound_m = 0.25;

bool is_near(const Pose& T_map_found, const Pose& T_map_true, const town::Constraint& truth) {
  const Eigen::Vector3d off_m = T_map_true.inverse() * T_map_found.translation();
  const bool is_near_ahead = truth.kept_ahead > 0.5 || std::abs(off_m.x()) <= kFound_m;
  return is_near_ahead && std::abs(off_m.y()) <= kFound_m;
}

void add_fault(WorldLocalizer& localizer, const TrueDrive& drive, std::size_t first, double left_m,
               FaultCounts& counts) {
  const ProtectionRow& row = protection_row(group_of_world(drive.kinds[first]));
  InformationScale scale = default_information_scale();
  scale.covariance_factor = row.covariance_factor;
  KnownStart start{drive.T_map_vehicle[first], tracking_start_covariance()};
  start.T_map_vehicle.translation() += start.T_map_vehicle.linear().col(1) * left_m;
  IntegrityMonitor monitor;
  bool is_alarmed = false;
  ++counts.faults;
  for (std::size_t k = first; k < first + kScans; ++k) {
    localizer.take(drive.scans[k]);
    const MatchResult found =
        localizer.match(start.T_map_vehicle, search_of_start_m(start.covariance));
    const MatchEnd end = localizer.end(found, start, scale);
    const Pose T_map_vehicle = end.estimate.T_map_vehicle;
    if (is_near(T_map_vehicle, drive.T_map_vehicle[k], drive.constraints[k])) {
      ++counts.found;
      return;
    }
    const Integrity match = integrity_of(found, localizer.point_count(), row);
    const Integrity all = monitor.add(match, end.raised, row);
    is_alarmed = is_alarmed || all != Integrity::kOk;
    if (k + 1 < drive.scans.size()) {
      start.T_map_vehicle =
          T_map_vehicle * (drive.T_map_vehicle[k].inverse() * drive.T_map_vehicle[k + 1]);
    }
  }
  counts.alarmed += is_alarmed ? 1 : 0;
}

}  // namespace

void add_faults(WorldLocalizer& localizer, const TrueDrive& drive, FaultTable& table) {
  double side = 1.0;
  for (std::size_t k = kEvery / 2; k + kScans <= drive.scans.size(); k += kEvery) {
    if (drive.constraints[k].kept_left > 0.5) continue;
    for (const double pull_m : kPulls_m) {
      const int cm = static_cast<int>(std::lround(100.0 * pull_m));
      add_fault(localizer, drive, k, side * pull_m, table[{drive.kinds[k], cm}]);
      side = -side;
    }
  }
}

void print_faults(const FaultTable& table) {
  std::printf("%-13s %6s %7s %6s %8s %7s\n", "kind", "pull m", "faults", "found", "alarmed",
              "neither");
  for (const auto& [key, counts] : table) {
    std::printf("%-13s %6.1f %7zu %6zu %8zu %7zu\n", key.first.c_str(), 0.01 * key.second,
                counts.faults, counts.found, counts.alarmed,
                counts.faults - counts.found - counts.alarmed);
  }
}

}  // namespace sightline
