#pragma once

#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/record/fields.h"

// What the factors of a map said, beside what a drive then measured. Only sites where the drive has
// a scan count.

namespace sightline {

// One range.
struct FactorsAtRange {
  double range_m = 0.0;
  // Spearman's, of each factor with the measured mean error; equal values share a rank; 0 where
  // all values are one.
  std::vector<double> rank_correlation;
  double virtual_points = 0.0;     // mean; what the map expects a scan to have
  double measured_points = 0.0;    // mean; what scans had
  double point_correlation = 0.0;  // Pearson's, over sites
  double expected_work = 0.0;      // points x iterations: a line through the map's virtual points
  double measured_work = 0.0;
  double expected_time_ms = 0.0;  // CPU time of one match, likewise
  double measured_time_ms = 0.0;
};
SIGHTLINE_FIELDS(FactorsAtRange, range_m, rank_correlation, virtual_points, measured_points,
                 point_correlation, expected_work, measured_work, expected_time_ms,
                 measured_time_ms)

struct FactorReport {
  std::vector<std::string> factors;
  std::vector<FactorsAtRange> ranges;  // ascending
  double point_correlation = 0.0;      // Pearson's, over all sites and ranges
};

// Expectations are least-squares lines of time and work over virtual_points, one for all ranges and
// sites. Errors: mismatched-inputs where sites or ranges differ or the table has no virtual_points;
// no-overlap where nothing was measured.
Result<FactorReport> factor_report(const FactorTable& factors, const MeasuredError& measured);

// "factor-rank-correlation" and "expected-time".
std::vector<Table> tables(const FactorReport& report);

// Both tables for people, aligned, with units.
std::string to_text(const FactorReport& report);

}  // namespace sightline
