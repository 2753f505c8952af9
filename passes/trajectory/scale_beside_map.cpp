#include "passes/trajectory/scale_beside_map.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "formats/base/parallel.h"
#include "passes/trajectory/graph/best_scale.h"
#include "passes/trajectory/local_match.h"
#include "passes/trajectory/place_drive.h"

namespace sightline {
namespace {

constexpr std::size_t kScansAsked = 8;

std::vector<std::size_t> scans_to_ask(const std::vector<std::uint8_t>& is_matched) {
  std::vector<std::size_t> matched;
  for (std::size_t k = 0; k < is_matched.size(); ++k) {
    if (is_matched[k] != 0) matched.push_back(k);
  }
  const std::size_t count = std::min(matched.size(), kScansAsked);
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < count; ++i) {
    some.push_back(matched[(2 * i + 1) * matched.size() / (2 * count)]);
  }
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

Result<double> scale_beside_map(const PassContext& ctx, const MatchGrid& grid, const Drive& drive,
                                const std::vector<Pose>& T_map_lidar,
                                const std::vector<std::uint8_t>& is_matched) {
  const std::vector<std::size_t> scans = scans_to_ask(is_matched);
  std::vector<Result<std::optional<double>>> told(scans.size(), std::optional<double>());
  parallel_for(scans.size(), ctx.threads, [&](std::size_t i) {
    told[i] = ratio_to_map(grid, drive, scans[i], T_map_lidar[scans[i]]);
  });
  std::vector<double> ratios;
  for (const Result<std::optional<double>>& ratio : told) {
    if (!ratio) return ratio.error();
    if (*ratio) ratios.push_back(**ratio);
  }
  return ratio_told_by(std::move(ratios));
}

}  // namespace sightline
