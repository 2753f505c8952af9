#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"
#include "formats/evaluation/look_evaluation.h"
#include "formats/geometry.h"
#include "formats/model/place_kind.h"
#include "formats/record/fields.h"

// How the ranges of a map fare on a drive. Coverage always stands beside time: a rule that misses
// the limit often is quick for that reason. Only sites where the drive has a scan are judged.
//
// Times are CPU times and differ from run to run; work (points x iterations) does not.

namespace sightline {

// One static range: a column of the paper's Table I.
struct StaticScore {
  double range_m = 0.0;
  double mean_error_m = 0.0;
  double mean_time_ms = 0.0;
  double max_site_time_ms = 0.0;  // greatest of the sites' means over offsets
  double max_run_time_ms = 0.0;   // greatest of single runs
  double mean_work = 0.0;
  double r_squared = 0.0;  // of predicted mean error; 0 where all measured errors are one
  double rmse_m = 0.0;
};
SIGHTLINE_FIELDS(StaticScore, range_m, mean_error_m, mean_time_ms, max_site_time_ms,
                 max_run_time_ms, mean_work, r_squared, rmse_m)

// Who chooses the range.
enum class Rule : std::uint8_t {
  kMap,                  // as the map says
  kMean,                 // the paper's: shortest with predicted mean error within the limit
  kProbability,          // shortest with P(error <= limit) >= p*, dilated
  kStaticEqualCoverage,  // shortest static range that covers what the map covers, else the longest
  kStaticLongest,
  kOracle,  // shortest that truly met the limit, else the longest
};
template <>
inline constexpr auto kNamesOf<Rule> = enum_names("map", "mean", "probability",
                                                  "static-equal-coverage", "static-longest",
                                                  "oracle");
inline constexpr std::size_t kRuleCount = kNamesOf<Rule>.size();

// One rule at one limit. Shares are of judged sites; ratios are to the static longest range, and 0
// where that took no time.
struct RuleScore {
  Rule rule = Rule::kMap;
  double limit_m = 0.0;
  double coverage = 0.0;  // error at the chosen range <= limit
  double mean_error_m = 0.0;
  double p95_error_m = 0.0;  // linear interpolation
  double mean_range_m = 0.0;
  double time_ratio = 0.0;
  double work_ratio = 0.0;
  double mean_time_ms = 0.0;
  double max_site_time_ms = 0.0;
  double max_run_time_ms = 0.0;
  double unmet_share = 0.0;         // no range was predicted, or was, good enough: not answered
  double extrapolated_share = 0.0;  // kMap only
  double worst_coverage = 0.0;      // of the worst stretch of route
  std::uint32_t worst_begin_site = 0;
  std::uint32_t worst_end_site = 0;  // its last site
  double answered_miss_share =
      0.0;  // of the answered sites, those over the limit; 0: none answered
  // Of the sites that are not answered, those where the longest range is over the limit too; 0
  // where all are answered.
  double truly_unmet_share = 0.0;
};
SIGHTLINE_FIELDS(RuleScore, rule, limit_m, coverage, mean_error_m, p95_error_m, mean_range_m,
                 time_ratio, work_ratio, mean_time_ms, max_site_time_ms, max_run_time_ms,
                 unmet_share, extrapolated_share, worst_coverage, worst_begin_site, worst_end_site,
                 answered_miss_share, truly_unmet_share)

// One rule at one limit over the judged sites of one kind of place.
struct KindScore {
  Rule rule = Rule::kMap;
  PlaceKind kind = PlaceKind::kUnknown;
  std::uint32_t site_count = 0;
  double limit_m = 0.0;
  double site_share = 0.0;  // of all judged sites
  double coverage = 0.0;
  double mean_error_m = 0.0;
  double p95_error_m = 0.0;
  double mean_range_m = 0.0;
  double time_ratio = 0.0;  // to the static longest range at the same sites
  double work_ratio = 0.0;
};
SIGHTLINE_FIELDS(KindScore, rule, kind, site_count, limit_m, site_share, coverage, mean_error_m,
                 p95_error_m, mean_range_m, time_ratio, work_ratio)

// Pairs (site, range) whose predicted P(error <= limit) lies in one tenth.
struct ReliabilityBin {
  double limit_m = 0.0;
  double promised = 0.0;  // mean predicted probability
  double observed = 0.0;  // share that met the limit
  std::uint32_t count = 0;
};
SIGHTLINE_FIELDS(ReliabilityBin, limit_m, promised, observed, count)

struct JudgedSite {
  std::uint32_t site = 0;
  std::uint32_t run = 0;
  double s_m = 0.0;
  double p_x_m = 0.0;  // map frame
  double p_y_m = 0.0;
  PlaceKind kind = PlaceKind::kUnknown;
};
SIGHTLINE_FIELDS(JudgedSite, site, run, s_m, p_x_m, p_y_m, kind)

struct Evaluation {
  std::string drive;
  ErrorReference reference = ErrorReference::kKnownPose;
  std::uint32_t site_count = 0;         // of the map
  std::uint32_t out_of_fold_count = 0;  // judged sites that were predicted out of fold
  double stretch_m = 0.0;               // length of the worst stretch
  std::vector<double> limits_m;
  std::vector<StaticScore> statics;         // ascending range_m
  std::vector<RuleScore> rules;             // [limit][rule]
  std::vector<ReliabilityBin> reliability;  // by limit, then ascending; empty tenths are left out
  // By limit, rule and type; types without a judged site are left out, and all are where the map
  // holds no factors.
  std::vector<KindScore> kinds;
  // What figures along the route are drawn from.
  std::vector<JudgedSite> sites;                 // ascending
  std::vector<double> error_m;                   // [judged site][range]
  std::vector<double> time_ms;                   // [judged site][range]
  std::vector<std::uint8_t> chosen_range_index;  // [limit][rule][judged site]
  std::optional<LookEvaluation> samples;         // of the looks that take a sample

  [[nodiscard]] const RuleScore& score(std::size_t limit, Rule rule) const {
    return rules[limit * kRuleCount + static_cast<std::size_t>(rule)];
  }
  [[nodiscard]] std::size_t chosen(std::size_t limit, Rule rule, std::size_t judged) const {
    const std::size_t row = limit * kRuleCount + static_cast<std::size_t>(rule);
    return chosen_range_index[row * sites.size() + judged];
  }
};
SIGHTLINE_FIELDS(Evaluation, drive, reference, site_count, out_of_fold_count, stretch_m, limits_m,
                 statics, rules, reliability, kinds, sites, error_m, time_ms, chosen_range_index,
                 samples)

template <>
struct ArtifactTraits<Evaluation> {
  static constexpr std::string_view kName = "evaluation";
  static constexpr std::uint32_t kVersion = 7;
};

Result<void> validate(const Evaluation& evaluation);
Table dump(const Evaluation& evaluation);  // the rules
// Rules, static ranges, kind of place, reliability, errors at every range, and the sites with
// every rule's choice (schemas/evaluation.schema.json).
std::vector<Table> tables(const Evaluation& evaluation);

// For people: the paper's Tables I and II, every rule at every limit with the worst stretch and
// its place in world coordinates, kind of place, and promised against observed coverage; aligned,
// with units. `frame`: of the map.
std::string to_text(const Evaluation& evaluation, const MapFrame& frame);

}  // namespace sightline
