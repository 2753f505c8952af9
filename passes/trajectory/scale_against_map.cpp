#include "passes/trajectory/scale_against_map.h"

#include <cstddef>
#include <optional>

#include "formats/base/statistics.h"
#include "passes/trajectory/graph/best_scale.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/place_drive.h"

namespace sightline {
namespace {

constexpr std::size_t kComparedScans = 8;

std::vector<std::size_t> scans_to_compare(const std::vector<std::uint8_t>& is_matched) {
  std::vector<std::size_t> matched;
  for (std::size_t k = 0; k < is_matched.size(); ++k) {
    if (is_matched[k] != 0) matched.push_back(k);
  }
  std::vector<std::size_t> some;
  for (const std::size_t i : evenly(matched.size(), kComparedScans)) some.push_back(matched[i]);
  return some;
}

Result<std::optional<double>> ratio_to_map(const MatchGrid& grid, const Drive& drive,
                                           std::size_t scan, const Pose& T_map_lidar) {
  SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive, scan, ThinnedFor::kMatch));
  const auto match = [&](const std::vector<Eigen::Vector3d>& scaled_m) {
    const MapMatch found = match_to_map(grid, scaled_m, T_map_lidar);
    return FitAtScale{found.likelihood * found.scored_share, found.is_good};
  };
  const std::optional<double> scale = best_scale(thinned.to_match_m, match);
  return scale ? std::optional(1.0 / *scale) : std::nullopt;
}

}  // namespace

Result<double> scale_against_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                 const std::vector<Pose>& T_map_lidar,
                                 const std::vector<std::uint8_t>& is_matched) {
  const std::vector<std::size_t> scans = scans_to_compare(is_matched);
  SIGHTLINE_ASSIGN(const std::vector<double> ratios,
                   ratios_of_scans(ctx.threads, scans.size(), [&](std::size_t i) {
                     return ratio_to_map(grid, drive, scans[i], T_map_lidar[scans[i]]);
                   }));
  return common_ratio(ratios);
}

}  // namespace sightline
