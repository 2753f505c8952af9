#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/base/random.h"

// A drive whose factors and errors come from a formula, for tests of learning and choosing. Places
// differ in how far their walls are, slowly along the route (correlation 0.5 at 24 m); factors see
// that through noise; errors fall with range and have a heavy tail, about as measured ones do.

namespace sightline {

struct SyntheticDrive {
  Sites sites;
  FactorTable factors;
  MeasuredError measured;
};

struct SyntheticOptions {
  std::size_t site_count = 600;
  std::vector<double> ranges_m = {10, 15, 20, 25, 30, 35, 40, 45, 50};
  bool has_paper_factors = true;  // else three
  std::size_t run_length = 0;     // sites in a run; 0: one run
  double error_scale = 1.0;
};

inline std::vector<std::string> synthetic_factor_names(bool has_paper_factors) {
  if (!has_paper_factors) return {"feature_count", "occupancy_ratio", "crlb_max"};
  return {"feature_count",  "d1_count",  "d2_count",      "d3_count",
          "d1_ratio",       "d2_ratio",  "d3_ratio",      "occupancy_ratio",
          "normal_entropy", "r_average", "score_entropy", "crlb_max"};
}

// Slowly varying standard normal numbers, one a site.
inline std::vector<double> synthetic_openness(Random& random, std::size_t count) {
  const double memory = std::pow(0.5, 1.0 / 24.0);
  std::vector<double> openness;
  double value = random.normal();
  for (std::size_t i = 0; i < count; ++i) {
    openness.push_back(value);
    value = memory * value + std::sqrt(1.0 - memory * memory) * random.normal();
  }
  return openness;
}

inline ErrorRow synthetic_row(Random& random, double openness, double range_m, double scale) {
  const double reach_m = 8.0 * std::exp(0.5 * openness);
  ErrorRow row;
  const double expected_m = 0.6 * std::exp(-range_m / reach_m) + 0.02;
  row.mean_m = scale * expected_m * std::exp(0.35 * random.normal());
  row.median_m = row.mean_m;
  row.p90_m = 1.5 * row.mean_m;
  row.max_m = 2.0 * row.mean_m;
  row.point_count = static_cast<std::uint32_t>(20.0 * range_m);
  row.mean_iterations = 8.0;
  row.mean_work = row.point_count * row.mean_iterations;
  row.max_work = 2.0 * row.mean_work;
  row.mean_time_ms = 1e-2 * row.mean_work * random.uniform(0.9, 1.1);
  row.max_time_ms = 1.5 * row.mean_time_ms;
  return row;
}

inline double synthetic_factor(Random& random, std::size_t factor, double openness,
                               double range_m) {
  const double seen = openness + 0.3 * random.normal();
  const double reach_m = 8.0 * std::exp(0.5 * seen);
  const double mixture = 0.3 * static_cast<double>(factor) + 0.2;
  return std::log1p(range_m / reach_m) * mixture + std::sin(mixture * seen) * (1.0 - mixture / 4.0);
}

inline SyntheticDrive synthetic_drive(std::uint64_t seed, const SyntheticOptions& options = {}) {
  Random random(seed);
  SyntheticDrive drive;
  const std::vector<double> openness = synthetic_openness(random, options.site_count);
  drive.factors.looks = drive.measured.looks = every_return_at(options.ranges_m);
  drive.factors.factors = synthetic_factor_names(options.has_paper_factors);
  drive.factors.site_count = static_cast<std::uint32_t>(options.site_count);
  drive.measured.drive = "synthetic";
  drive.measured.offsets.resize(12);
  const std::size_t run_length = options.run_length == 0 ? options.site_count : options.run_length;
  for (std::size_t i = 0; i < options.site_count; ++i) {
    Site site;
    site.run = static_cast<std::uint32_t>(i / run_length);
    site.s_m = static_cast<double>(i % run_length);
    site.p_map_m = Eigen::Vector3d(static_cast<double>(i), 0.0, 1.8);
    site.T_map_vehicle.translation() = Eigen::Vector3d(static_cast<double>(i), 0.0, 0.0);
    drive.sites.sites.push_back(site);
    drive.measured.scan_of_site.push_back(static_cast<std::int64_t>(i));
    for (const double range_m : options.ranges_m) {
      drive.measured.rows.push_back(
          synthetic_row(random, openness[i], range_m, options.error_scale));
      for (std::size_t f = 0; f < drive.factors.factors.size(); ++f) {
        drive.factors.values.push_back(synthetic_factor(random, f, openness[i], range_m));
      }
    }
  }
  return drive;
}

}  // namespace sightline
