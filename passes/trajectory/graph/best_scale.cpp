#include "passes/trajectory/graph/best_scale.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr double kScaleStep = 0.005;
constexpr int kScaleSteps = 8;  // to either side of 1
constexpr double kMostDifference = 0.003;

// Fits by scale, in steps from 1; each scale is matched once.
class FitByScale {
 public:
  FitByScale(const std::vector<Eigen::Vector3d>& points_m, const MatchAtScale& match)
      : points_m_(points_m), match_(match) {}

  // A logarithm: its top is a parabola.
  double at(int step) {
    constexpr double kLeast = 1e-3;  // finite where nothing fits
    return portable_log(std::max(kLeast, match_at(step).fit));
  }

  const FitAtScale& match_at(int step) {
    const auto [known, is_new] = matches_.try_emplace(step);
    if (!is_new) return known->second;
    const double scale = 1.0 + kScaleStep * step;
    std::vector<Eigen::Vector3d> scaled_m;
    for (const Eigen::Vector3d& point_m : points_m_) scaled_m.push_back(scale * point_m);
    return known->second = match_(scaled_m);
  }

 private:
  const std::vector<Eigen::Vector3d>& points_m_;
  const MatchAtScale& match_;
  std::map<int, FitAtScale> matches_;
};

}  // namespace

std::optional<double> best_scale(const std::vector<Eigen::Vector3d>& points_m,
                                 const MatchAtScale& match) {
  FitByScale fit(points_m, match);
  int best = 0;
  for (int step = -kScaleSteps; step <= kScaleSteps; step += 2) {
    if (fit.at(step) > fit.at(best)) best = step;
  }
  if (std::abs(best) == kScaleSteps) return std::nullopt;
  for (const int step : {best - 1, best + 1}) {
    if (fit.at(step) > fit.at(best)) best = step;
  }
  if (!fit.match_at(best).is_sure) return std::nullopt;
  const double over_less = fit.at(best) - fit.at(best - 1);
  const double over_more = fit.at(best) - fit.at(best + 1);
  const double sum = over_less + over_more;
  return 1.0 + kScaleStep * (best + (sum > 0.0 ? 0.5 * (over_less - over_more) / sum : 0.0));
}

Result<std::vector<double>> ratios_of_scans(
    int threads, std::size_t count,
    const std::function<Result<std::optional<double>>(std::size_t)>& ratio_of) {
  SIGHTLINE_ASSIGN(const std::vector<std::optional<double>> measured,
                   parallel_results<std::optional<double>>(count, threads, ratio_of));
  std::vector<double> ratios;
  for (const std::optional<double>& ratio : measured) {
    if (ratio) ratios.push_back(*ratio);
  }
  return ratios;
}

double common_ratio(std::vector<double> ratios) {
  if (ratios.size() < kLeastRatios) return 1.0;
  std::ranges::sort(ratios);
  const double off = ratios[ratios.size() / 2] - 1.0;
  if (std::abs(off) <= kMostDifference) return 1.0;
  const double way = off > 0.0 ? 1.0 : -1.0;
  const auto agreeing = std::ranges::count_if(
      ratios, [&](double ratio) { return way * (ratio - 1.0) > 0.5 * kMostDifference; });
  return 4 * static_cast<std::size_t>(agreeing) >= 3 * ratios.size() ? 1.0 + off : 1.0;
}

}  // namespace sightline
