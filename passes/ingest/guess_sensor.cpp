#include "passes/ingest/guess_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/drive/sensor_profile.h"

namespace sightline {
namespace {

// Nearer than this the offsets between a sensor's beams bend elevations, and it sees its vehicle.
constexpr double kNearest_m = 3.0;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;

// Ascending.
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

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

// How the elevations lie among the beams of a profile.
struct Fit {
  double off = 1.0;     // mean distance to the nearest beam, in gaps between beams; 0.25 by chance
  double inside = 0.0;  // share of returns within half a gap of a beam
  double hit = 0.0;     // share of beams with returns
};

Fit fit_beams(const std::vector<double>& elevations, const std::vector<double>& beams_deg) {
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
  Fit fit;
  fit.off = sum / count;
  std::size_t inside = 0;
  for (const std::size_t hit : hits) inside += hit;
  fit.inside = static_cast<double>(inside) / count;
  fit.hit = static_cast<double>(std::ranges::count_if(
                hits, [&](std::size_t hit) { return static_cast<double>(hit) > least; })) /
            static_cast<double>(hits.size());
  return fit;
}

std::string degrees(double lowest_deg, double highest_deg) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.1f to %.1f degrees", lowest_deg, highest_deg);
  return text.data();
}

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %";
}

// Where beams are told apart: the real sensor of that name before an example's of equal beams.
bool choose_by_beams(const std::vector<double>& elevations, SensorGuess& guess) {
  constexpr double kCrisp = 0.15;
  Fit best;
  for (const std::string& name : sensor_profile_names()) {
    const Fit fit = fit_beams(elevations, sensor_profile(name)->beam_elevations_deg);
    if (fit.off > kCrisp || fit.inside < 0.9 || fit.hit < 0.8 || fit.off > best.off) continue;
    best = fit;
    guess.profile = name;
  }
  if (guess.profile.empty()) return false;
  guess.reason = percent(best.hit) + " of its beams are hit, and returns lie " + percent(best.off) +
                 " of a gap beside a beam (25 % by chance)";
  return true;
}

bool choose_by_span(const std::vector<double>& elevations, SensorGuess& guess) {
  constexpr double kNear_deg = 2.0;
  double best_deg = kNear_deg;
  for (const std::string& name : sensor_profile_names()) {
    const std::vector<double> beams_deg = sensor_profile(name)->beam_elevations_deg;
    const double off_deg = std::max(std::abs(beams_deg.front() - guess.lowest_beam_deg),
                                    std::abs(beams_deg.back() - guess.highest_beam_deg));
    if (off_deg > best_deg || fit_beams(elevations, beams_deg).hit < 0.9) continue;
    best_deg = off_deg;
    guess.profile = name;
  }
  if (guess.profile.empty()) return false;
  guess.reason = "returns span " + degrees(guess.lowest_beam_deg, guess.highest_beam_deg) +
                 " like its beams, which cannot be told apart in these scans";
  return true;
}

// Runs of elevations without a gap of a tenth of a degree; more than sensors have: no beams.
int count_rings(const std::vector<double>& elevations) {
  constexpr double kGap_deg = 0.1;
  // A beam that sees only sky leaves stray returns.
  const std::size_t least = elevations.size() / 5000 + 1;
  int rings = 0;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= elevations.size(); ++i) {
    if (i < elevations.size() && elevations[i] - elevations[i - 1] < kGap_deg) continue;
    rings += i - first >= least ? 1 : 0;
    first = i;
  }
  return rings;
}

void describe_beams(const std::vector<double>& elevations, SensorGuess& guess) {
  guess.rings = count_rings(elevations);
  const std::string span = degrees(guess.lowest_beam_deg, guess.highest_beam_deg);
  if (guess.rings >= 8) {
    guess.reason = "no built-in profile fits; " + std::to_string(guess.rings) +
                   " beams are told apart from " + span;
    return;
  }
  guess.rings = 64;
  guess.reason =
      "no built-in profile fits and beams cannot be told apart: please correct the "
      "number; returns span " +
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
  return std::round(quantile(heights_m, 0.5) * 100.0) / 100.0;
}

}  // namespace

SensorGuess guess_sensor(std::span<const PointCloudFile> scans) {
  SensorGuess guess;
  const std::vector<double> elevations = elevations_deg(scans);
  if (!elevations.empty()) {
    // Stray returns above and below the beams are few.
    guess.lowest_beam_deg = std::round(quantile(elevations, 0.002) * 100.0) / 100.0;
    guess.highest_beam_deg = std::round(quantile(elevations, 0.998) * 100.0) / 100.0;
  }
  if (guess.highest_beam_deg - guess.lowest_beam_deg < 1.0) {
    guess.profile = "generic-16";
    guess.reason = "returns farther than 3 m say nothing of the beams: please name the sensor";
    return guess;
  }
  if (!choose_by_beams(elevations, guess) && !choose_by_span(elevations, guess)) {
    describe_beams(elevations, guess);
  }
  guess.height_m = middle_height(scans);
  return guess;
}

}  // namespace sightline
