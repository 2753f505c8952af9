#include "passes/ingest/guess_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/drive/sensor_profile.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Nearer than this a sensor sees its vehicle.
constexpr double kNearest_m = 3.0;

// Where beams are distinguished: the real sensor of that name before an example's of equal beams.
bool choose_by_beams(const std::vector<double>& elevations, SensorGuess& guess) {
  BeamFit best;
  for (const std::string& name : sensor_profile_names()) {
    const SensorProfile profile = *sensor_profile(name);
    if (!profile.sees_all_round()) continue;  // its rings stand for a pattern without any
    const BeamFit fit = fit_beams(elevations, profile.beam_elevations_deg);
    if (!fit.is_crisp() || fit.off > best.off) continue;
    best = fit;
    guess.profile = name;
  }
  if (guess.profile.empty()) return false;
  guess.reason =
      concat(whole_percent(best.hit), " of its beams have returns, which are at ",
             whole_percent(best.off), " of the gap from a beam on average (25 % by chance)");
  return true;
}

// Returns that fill the view of a profile that does not see all round, from side to side and at
// least half of its height: what looks at the sky returns nothing.
bool choose_by_view(double view_deg, SensorGuess& guess) {
  constexpr double kNear_deg = 4.0;
  constexpr double kMargin_deg = 1.0;
  for (const std::string& name : sensor_profile_names()) {
    const SensorProfile profile = *sensor_profile(name);
    const double lowest_deg = profile.beam_elevations_deg.front();
    const double highest_deg = profile.beam_elevations_deg.back();
    const double seen_deg = guess.highest_beam_deg - guess.lowest_beam_deg;
    const bool is_within = guess.lowest_beam_deg >= lowest_deg - kMargin_deg &&
                           guess.highest_beam_deg <= highest_deg + kMargin_deg;
    if (profile.sees_all_round() || std::abs(profile.azimuth_view_deg - view_deg) > kNear_deg ||
        !is_within || seen_deg < 0.5 * (highest_deg - lowest_deg)) {
      continue;
    }
    guess.profile = name;
    guess.reason = fmt::format(
        "returns are within {} degrees of azimuth and from {}, which is its view",
        format_double(view_deg), to_text(BeamSpan{guess.lowest_beam_deg, guess.highest_beam_deg}));
    return true;
  }
  return false;
}

bool choose_by_span(const std::vector<double>& elevations, SensorGuess& guess) {
  constexpr double kNear_deg = 2.0;
  double best_deg = kNear_deg;
  for (const std::string& name : sensor_profile_names()) {
    const SensorProfile profile = *sensor_profile(name);
    if (!profile.sees_all_round()) continue;
    const std::vector<double>& beams_deg = profile.beam_elevations_deg;
    const double off_deg = std::max(std::abs(beams_deg.front() - guess.lowest_beam_deg),
                                    std::abs(beams_deg.back() - guess.highest_beam_deg));
    if (off_deg > best_deg || fit_beams(elevations, beams_deg).hit < 0.9) continue;
    best_deg = off_deg;
    guess.profile = name;
  }
  if (guess.profile.empty()) return false;
  guess.reason =
      concat("returns span ", to_text(BeamSpan{guess.lowest_beam_deg, guess.highest_beam_deg}),
             " like its beams, which these scans do not resolve");
  return true;
}

// Beams by runs of elevations without a gap of a tenth of a degree.
struct Rings {
  int told_apart = 0;  // runs as narrow as a beam
  int merged = 0;  // beams in the wider ones, if each has the returns of one that is distinguished
};

Rings count_rings(const std::vector<double>& elevations) {
  constexpr double kGap_deg = 0.1;
  constexpr double kWidest_deg = 0.3;
  // A beam that sees only sky leaves stray returns.
  const std::size_t least = elevations.size() / 5000 + 1;
  std::vector<std::size_t> beams;
  std::size_t in_wide_runs = 0;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= elevations.size(); ++i) {
    if (i < elevations.size() && elevations[i] - elevations[i - 1] < kGap_deg) continue;
    const bool is_narrow = elevations[i - 1] - elevations[first] < kWidest_deg;
    if (!is_narrow) in_wide_runs += i - first;
    if (is_narrow && i - first >= least) beams.push_back(i - first);
    first = i;
  }
  if (beams.empty()) return {};
  // One that sees little sky.
  const auto full = beams.begin() + static_cast<std::ptrdiff_t>(beams.size() * 3 / 4);
  std::ranges::nth_element(beams, full);
  return {static_cast<int>(beams.size()), static_cast<int>((in_wide_runs + *full / 2) / *full)};
}

void describe_beams(const std::vector<double>& elevations, SensorGuess& guess) {
  const Rings rings = count_rings(elevations);
  const std::string span = to_text(BeamSpan{guess.lowest_beam_deg, guess.highest_beam_deg});
  guess.rings = rings.told_apart + rings.merged;
  if (rings.told_apart >= 8) {
    guess.reason = fmt::format("no built-in profile fits; {} distinct beams are found from {}",
                               rings.told_apart, span);
    if (rings.merged > 0) {
      guess.reason +=
          concat(", and the returns between them match ", rings.merged, " more: check the number");
    }
    return;
  }
  guess.rings = 64;
  guess.reason =
      "no built-in profile fits and these scans do not resolve beams: correct the number; returns "
      "span " +
      span;
}

// The ground near the sensor is the level with most returns below it.
std::optional<double> height_above_ground(const PointCloudFile& scan) {
  constexpr double kReach_m = 12.0;
  constexpr double kBin_m = 0.05;
  constexpr double kLowest_m = -5.0;
  std::vector<double> bins(static_cast<std::size_t>(-kLowest_m / kBin_m), 0.0);
  double count = 0.0;
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    const double away_m = point_m.head<2>().norm();
    if (away_m < kNearest_m || away_m > kReach_m) continue;
    count += 1.0;
    if (point_m.z() >= 0.0 || point_m.z() <= kLowest_m) continue;
    bins[static_cast<std::size_t>((point_m.z() - kLowest_m) / kBin_m)] += 1.0;
  }
  const auto fullest = std::ranges::max_element(bins);
  const auto at = static_cast<double>(fullest - bins.begin());
  const double height_m = -(kLowest_m + (at + 0.5) * kBin_m);
  // A wall spreads over many levels; a ground nearer than half a metre is that of a vehicle's
  // frame.
  constexpr double kLeastShare = 0.03;
  constexpr double kLeastHeight_m = 0.5;
  if (*fullest < kLeastShare * count || height_m < kLeastHeight_m) return std::nullopt;
  return height_m;
}

// The middle one of the scans that see ground, in centimetres.
std::optional<double> middle_height(std::span<const PointCloudFile> scans) {
  std::vector<double> heights_m;
  for (const PointCloudFile& scan : scans) {
    const std::optional<double> height_m = height_above_ground(scan);
    if (height_m) heights_m.push_back(*height_m);
  }
  if (heights_m.empty()) return std::nullopt;
  std::ranges::sort(heights_m);
  return std::round(heights_m[(heights_m.size() - 1) / 2] * 100.0) / 100.0;
}

constexpr double kStray = 0.002;

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

SensorGuess guess_sensor(std::span<const PointCloudFile> scans) {
  SensorGuess guess;
  const std::vector<double> elevations = elevations_deg(scans);
  if (!elevations.empty()) {
    const BeamSpan span = span_of(elevations);
    guess.lowest_beam_deg = std::round(span.lowest_deg * 100.0) / 100.0;
    guess.highest_beam_deg = std::round(span.highest_deg * 100.0) / 100.0;
  }
  if (guess.highest_beam_deg - guess.lowest_beam_deg < 1.0) {
    guess.profile = "generic-16";
    guess.reason = "returns farther than 3 m do not show the beams: name the sensor";
    return guess;
  }
  const double view_deg = azimuth_view_deg(scans);
  if (!choose_by_beams(elevations, guess) && !choose_by_view(view_deg, guess) &&
      !choose_by_span(elevations, guess)) {
    describe_beams(elevations, guess);
  }
  const bool has_view = !guess.profile.empty() && !sensor_profile(guess.profile)->sees_all_round();
  if (view_deg < 360.0 && !has_view) guess.azimuth_view_deg = view_deg;
  guess.height_m = middle_height(scans);
  return guess;
}

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
  return concat(fixed(span.lowest_deg, 1), " to ", fixed(span.highest_deg, 1), " degrees");
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
  fit.inside =
      static_cast<double>(std::accumulate(hits.begin(), hits.end(), std::size_t{0})) / count;
  fit.hit = static_cast<double>(std::ranges::count_if(
                hits, [&](std::size_t hit) { return static_cast<double>(hit) > least; })) /
            static_cast<double>(hits.size());
  return fit;
}

}  // namespace sightline
