#include "passes/ingest/check_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"
#include "passes/ingest/guess_sensor.h"
#include "passes/pass/notices.h"

// A profile is contradicted by what it cannot explain, not by what a place does not show: beams
// that look at the sky return nothing, so that few returns high up say little. Three things do not
// depend on the place. Returns lie at beams alone, within the sensor's view in azimuth; ground lies
// below the sensor; and above the horizon, where a place ends, returns become fewer by degrees,
// while where beams end they stop all at once.
//
// Beams of one LiDAR leave it at up to 0.2 m above each other, and motion taken out of a scan bends
// it: real ones have up to 0.6 % of their returns over a degree outside their own beams.

namespace sightline {
namespace {

constexpr std::size_t kLeastReturns = 1000;
constexpr double kNearest_m = 3.0;
constexpr double kMargin_deg = 1.0;
constexpr double kOutside = 0.02;
constexpr double kMostlyOutside = 0.5;
constexpr double kIdle_deg = 5.0;  // so far beams go on beyond the returns
// Half the speed of rotation makes twice as many, second returns some more.
constexpr double kMostReturnsPerRay = 2.5;
constexpr double kBeyondRange = 0.05;

double share_between(const std::vector<double>& elevations, double low_deg, double high_deg) {
  const auto low = std::ranges::lower_bound(elevations, low_deg);
  const auto high = std::ranges::upper_bound(elevations, high_deg);
  return static_cast<double>(std::max<std::ptrdiff_t>(high - low, 0)) /
         static_cast<double>(elevations.size());
}

double share_outside(const std::vector<double>& elevations, const BeamSpan& beams) {
  return 1.0 -
         share_between(elevations, beams.lowest_deg - kMargin_deg, beams.highest_deg + kMargin_deg);
}

// Of the returns farther than elevations_deg() leaves out.
double share_out_of_view(const std::vector<PointCloudFile>& scans, const SensorProfile& sensor) {
  if (sensor.sees_all_round()) return 0.0;
  const double widest_deg = 0.5 * sensor.azimuth_view_deg + kMargin_deg;
  double all = 0.0;
  double outside = 0.0;
  for (const PointCloudFile& scan : scans) {
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      if (point_m.squaredNorm() < kNearest_m * kNearest_m) continue;
      const double aside_deg = std::abs(portable_atan2(point_m.y(), point_m.x())) * kDegPerRad;
      all += 1.0;
      outside += aside_deg > widest_deg ? 1.0 : 0.0;
    }
  }
  return outside / all;
}

// Whether the last returns are about as dense as all of them: then beams end there, not the place.
bool end_at_once(const std::vector<double>& elevations, double from_deg, double to_deg) {
  constexpr double kLeastDensity = 0.5;
  const BeamSpan seen = span_of(elevations);
  const double even = (to_deg - from_deg) / (seen.highest_deg - seen.lowest_deg);
  return share_between(elevations, from_deg, to_deg) >= kLeastDensity * even;
}

// Beams go on below the last returns although ground must lie there, at least 4 m away.
bool are_idle_below(const std::vector<double>& elevations, const SensorProfile& sensor,
                    const SensorGuess& guess) {
  constexpr double kNearestGround_m = 4.0;
  constexpr double kLeastCosine = 0.98;  // of a sensor that is level
  if (sensor.T_vehicle_lidar(2, 2) < kLeastCosine || !guess.height_m) return false;
  const double sine = std::clamp(*guess.height_m / kNearestGround_m, 0.0, 1.0);
  const double lowest_deg =
      std::max(sensor.beam_elevations_deg.front(), -portable_asin(sine) * kDegPerRad);
  return lowest_deg < span_of(elevations).lowest_deg - kIdle_deg;
}

// Beams go on above the last returns although those end there all at once, above the horizon.
bool are_idle_above(const std::vector<double>& elevations, const SensorProfile& sensor) {
  constexpr double kHorizon_deg = 2.0;  // a flat country's, seen from a vehicle that pitches
  constexpr double kEdge_deg = 4.0;     // wider than any gap between beams
  const double highest_deg = span_of(elevations).highest_deg;
  return highest_deg > kHorizon_deg &&
         sensor.beam_elevations_deg.back() > highest_deg + kIdle_deg &&
         end_at_once(elevations, highest_deg - kEdge_deg, highest_deg);
}

// Whether the returns stand at beams, and at others than those of the profile.
bool are_other_beams(const std::vector<double>& elevations, const SensorProfile& sensor,
                     const SensorGuess& guess) {
  if (guess.profile.empty() || fit_beams(elevations, sensor.beam_elevations_deg).is_crisp()) {
    return false;
  }
  const Result<SensorProfile> guessed = sensor_profile(guess.profile);
  return guessed && fit_beams(elevations, guessed->beam_elevations_deg).is_crisp();
}

// Returns end at the sides of a sector that the profile sees far beyond.
bool is_view_half_empty(const SensorProfile& sensor, const SensorGuess& guess) {
  constexpr double kIdleView_deg = 20.0;
  return guess.azimuth_view_deg &&
         *guess.azimuth_view_deg < sensor.azimuth_view_deg - kIdleView_deg;
}

double returns_per_ray(const std::vector<PointCloudFile>& scans, const SensorProfile& sensor) {
  const double rays = sensor.ring_count() * sensor.azimuth_view_deg / sensor.azimuth_step_deg;
  std::size_t most = 0;
  for (const PointCloudFile& scan : scans) most = std::max(most, scan.points_m.size());
  return static_cast<double>(most) / rays;
}

double share_beyond_range(const std::vector<PointCloudFile>& scans, const SensorProfile& sensor) {
  double all = 0.0;
  double beyond = 0.0;
  for (const PointCloudFile& scan : scans) {
    for (const Eigen::Vector3d& point_m : scan.points_m) {
      all += 1.0;
      beyond += point_m.squaredNorm() > sensor.max_range_m * sensor.max_range_m ? 1.0 : 0.0;
    }
  }
  return beyond / all;
}

// What contradicts the profile; empty: nothing does.
std::string contradiction(const std::vector<PointCloudFile>& scans,
                          const std::vector<double>& elevations, const SensorProfile& sensor,
                          const SensorGuess& guess) {
  const double outside = share_outside(
      elevations, {sensor.beam_elevations_deg.front(), sensor.beam_elevations_deg.back()});
  if (outside >= kOutside) return whole_percent(outside) + " of the returns are outside these";
  const double out_of_view = share_out_of_view(scans, sensor);
  if (out_of_view >= kOutside) {
    return fmt::format("{} of the returns are outside its azimuth view of {} degrees",
                       whole_percent(out_of_view), format_double(sensor.azimuth_view_deg));
  }
  if (is_view_half_empty(sensor, guess)) {
    return fmt::format(
        "all returns are within {} degrees of azimuth about its x axis, but its view is {} degrees",
        format_double(*guess.azimuth_view_deg), format_double(sensor.azimuth_view_deg));
  }
  if (are_idle_below(elevations, sensor, guess)) {
    return "the lowest beams have no returns from the ground";
  }
  if (are_idle_above(elevations, sensor))
    return "the highest returns are far below the highest beam";
  if (are_other_beams(elevations, sensor, guess))
    return "the returns are at other elevations than these beams";
  const double per_ray = returns_per_ray(scans, sensor);
  if (per_ray > kMostReturnsPerRay) {
    return concat("a scan has ", format_double(std::round(per_ray * 10.0) / 10.0),
                  " times as many returns as these have rays");
  }
  const double beyond = share_beyond_range(scans, sensor);
  if (beyond < kBeyondRange) return "";
  return concat(whole_percent(beyond), " of the returns are beyond its range of ",
                format_double(sensor.max_range_m), " m and are left out of the map");
}

std::string guess_text(const SensorGuess& guess) {
  const std::string view =
      guess.azimuth_view_deg
          ? concat(", `azimuth_view_deg: ", format_double(*guess.azimuth_view_deg), "`")
          : "";
  if (!guess.profile.empty()) return concat("`sensor: ", guess.profile, "`", view);
  return fmt::format("`rings: {}`, `lowest_beam_deg: {}`, `highest_beam_deg: {}`{}", guess.rings,
                     format_double(guess.lowest_beam_deg), format_double(guess.highest_beam_deg),
                     view);
}

Error misfit(const Recording& recording, const std::vector<double>& elevations,
             const std::string& what, const SensorGuess& guess) {
  const SensorProfile& sensor = recording.sensor;
  const BeamSpan beams{sensor.beam_elevations_deg.front(), sensor.beam_elevations_deg.back()};
  return {ErrorCode::kUnlikeProfile,
          fmt::format("the sensor {} has {} beams from {}, but {}. The returns span {}; `sightline "
                      "init` suggests {} ({})",
                      sensor.name, sensor.ring_count(), to_text(beams), what,
                      to_text(span_of(elevations)), guess_text(guess), guess.reason),
          "", "drive " + recording.name};
}

}  // namespace

Result<void> check_sensor(PassContext& ctx, const Recording& recording,
                          std::vector<Notice>& notices) {
  const SensorProfile& sensor = recording.sensor;
  if (sensor.ring_count() < 2) return {};
  std::vector<PointCloudFile> scans;
  for (const std::size_t index : sample_scans(recording.scans.size())) {
    SIGHTLINE_ASSIGN(PointCloudFile scan, read_recorded_scan(recording, index));
    scans.push_back(std::move(scan));
  }
  const std::vector<double> elevations = elevations_deg(scans);
  if (elevations.size() < kLeastReturns) return {};
  const SensorGuess guess = guess_sensor(scans);
  const std::string what = contradiction(scans, elevations, sensor, guess);
  if (what.empty()) return {};
  Error error = misfit(recording, elevations, what, guess);
  const BeamSpan beams{sensor.beam_elevations_deg.front(), sensor.beam_elevations_deg.back()};
  if (share_outside(elevations, beams) >= kMostlyOutside ||
      share_out_of_view(scans, sensor) >= kMostlyOutside) {
    error.message += ". Most returns contradict this profile, so no map is made: correct `sensor`";
    return error;
  }
  const std::string text =
      to_string(error) +
      ". Factors and predictions are computed for this profile's beams: correct `sensor` if it is "
      "wrong";
  notices.push_back(warned(ctx, {.code = "unlike-profile", .text = text, .unit = ""}));
  return {};
}

}  // namespace sightline
