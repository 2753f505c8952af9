#include "passes/ingest/beam_fit.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

constexpr double kNearest_m = 3.0;
constexpr double kStray = 0.002;

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

std::vector<std::size_t> sample_scans(std::size_t scan_count) {
  constexpr std::size_t kSamples = 5;
  std::vector<std::size_t> samples;
  for (std::size_t k = 0; k < kSamples && scan_count > 0; ++k) {
    const std::size_t index = k * (scan_count - 1) / (kSamples - 1);
    if (samples.empty() || samples.back() != index) samples.push_back(index);
  }
  return samples;
}

std::vector<double> elevations_deg(std::span<const PointCloudFile> scans) {
  std::vector<double> elevations;
  for (const PointCloudFile& scan : scans) {
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      if (point_m.squaredNorm() < kNearest_m * kNearest_m) continue;
      elevations.push_back(portable_atan2(point_m.z(), point_m.head<2>().norm()) * kDegPerRad);
    }
  }
  std::ranges::sort(elevations);
  return elevations;
}

BeamSpan span_of(const std::vector<double>& elevations) {
  return {quantile(elevations, kStray), quantile(elevations, 1.0 - kStray)};
}

std::string to_text(const BeamSpan& span) {
  return fixed(span.lowest_deg, 1) + " to " + fixed(span.highest_deg, 1) + " degrees";
}

double azimuth_view_deg(std::span<const PointCloudFile> scans) {
  constexpr std::size_t kLeastReturns = 1000;
  // A sensor that sees all round has returns at its sides and behind it wherever it stands.
  constexpr double kWidest_deg = 240.0;
  std::vector<double> aside_deg;
  for (const PointCloudFile& scan : scans) {
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      if (point_m.squaredNorm() < kNearest_m * kNearest_m) continue;
      aside_deg.push_back(std::abs(portable_atan2(point_m.y(), point_m.x())) * kDegPerRad);
    }
  }
  if (aside_deg.size() < kLeastReturns) return 360.0;
  std::ranges::sort(aside_deg);
  const double view_deg = std::ceil(20.0 * quantile(aside_deg, 1.0 - kStray)) / 10.0;
  return view_deg <= kWidest_deg ? view_deg : 360.0;
}

BeamFit fit_beams(const std::vector<double>& elevations, const std::vector<double>& beams_deg) {
  std::vector<std::size_t> hits(beams_deg.size(), 0);
  double sum = 0.0;
  for (const double elevation : elevations) {
    const auto above = std::ranges::lower_bound(beams_deg, elevation);
    auto beam = static_cast<std::size_t>(above - beams_deg.begin());
    if (beam == beams_deg.size() ||
        (beam > 0 && elevation - beams_deg[beam - 1] < beams_deg[beam] - elevation)) {
      --beam;
    }
    const std::size_t low = std::min(beam, beams_deg.size() - 2);
    const double gap_deg = beams_deg[low + 1] - beams_deg[low];
    const double off = std::abs(elevation - beams_deg[beam]) / gap_deg;
    sum += std::min(off, 0.5);
    if (off <= 0.5) ++hits[beam];
  }
  const auto count = static_cast<double>(elevations.size());
  const double least = 0.05 * count / static_cast<double>(beams_deg.size());
  BeamFit fit;
  fit.off = sum / count;
  std::size_t inside = 0;
  for (const std::size_t hit : hits) inside += hit;
  fit.inside = static_cast<double>(inside) / count;
  fit.hit = static_cast<double>(std::ranges::count_if(
                hits, [&](std::size_t hit) { return static_cast<double>(hit) > least; })) /
            static_cast<double>(hits.size());
  return fit;
}

}  // namespace sightline
