#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/look.h"
#include "formats/record/fields.h"
#include "formats/text/table.h"

// How the looks of a map that take a sample fare on a drive, beside what any vehicle may do without
// them (formats/evaluation/evaluation.h). Times and works are over those of the longest range with
// every return, at the same sites.

namespace sightline {

// The same look everywhere. "50 m" and the like: every return within the range.
struct StaticLook {
  Look look;
  std::vector<double> coverage;  // [limit]
  double mean_error_m = 0.0;
  double time_ratio = 0.0;
  double work_ratio = 0.0;
};
SIGHTLINE_FIELDS(StaticLook, look, coverage, mean_error_m, time_ratio, work_ratio)

// Who chooses the look.
enum class LookRule : std::uint8_t {
  kMap,             // as the map says
  kSameEverywhere,  // the same look everywhere that costs least at the coverage of kMap
  kSameWithoutMap,  // the same among looks that do not go by the map's normals
  kOracle           // cheapest that truly met the limit, else the most accurate
};
template <>
inline constexpr auto kNamesOf<LookRule> = enum_names("map", "static", "static-without-map",
                                                      "oracle");
inline constexpr std::size_t kLookRuleCount = kNamesOf<LookRule>.size();

// One rule at one limit. The coverage of a static one is that of kMap where it reaches it: linear
// between neighbours on the frontier of least time; else the most accurate look stands there with
// its own coverage.
struct LookRuleScore {
  LookRule rule = LookRule::kMap;
  double limit_m = 0.0;
  double coverage = 0.0;
  double time_ratio = 0.0;
  double work_ratio = 0.0;
  // Of kMap: as in RuleScore (formats/evaluation/evaluation.h), with the dearest look of the map in
  // place of the longest range. Other rules answer every site.
  double unmet_share = 0.0;
  double answered_miss_share = 0.0;
  double truly_unmet_share = 0.0;
};
SIGHTLINE_FIELDS(LookRuleScore, rule, limit_m, coverage, time_ratio, work_ratio, unmet_share,
                 answered_miss_share, truly_unmet_share)

struct LookEvaluation {
  std::vector<double> limits_m;
  // Whether the drive was measured at looks beside the map's own that no map is needed for; where
  // it was not, kSameWithoutMap is left out of texts and tables: ranges alone would be a weak
  // judge.
  bool has_baselines = false;
  std::vector<StaticLook> statics;
  std::vector<LookRuleScore> rules;  // [limit][rule]

  [[nodiscard]] const LookRuleScore& score(std::size_t limit, LookRule rule) const {
    return rules[limit * kLookRuleCount + static_cast<std::size_t>(rule)];
  }
};
SIGHTLINE_FIELDS(LookEvaluation, limits_m, has_baselines, statics, rules)

Result<void> validate(const LookEvaluation& evaluation);
std::vector<Table> tables(const LookEvaluation& evaluation);
// For people: the rules at each limit, what the annotation is worth in a sentence, every look.
std::string to_text(const LookEvaluation& evaluation);

// What a rule achieves: the share of places that it serves, and what it costs there (work or time).
struct CoveredCost {
  double coverage = 0.0;
  double cost = 0.0;
};

// What it costs to serve as many places.
struct CostAtCoverage {
  double coverage = 0.0;  // that was asked for, or, where it is not reached, the most that there is
  double cost = 0.0;
  bool is_reached = false;
};

// The cost of `coverage` with answers that are the same everywhere: linear between neighbours of
// those that no other answer beats, the cheapest of all below them, and above them the one of most
// coverage, with its own. A mixture of two neighbours, at random places, costs as much.
// At least one answer.
CostAtCoverage cost_at_coverage(std::span<const CoveredCost> answers, double coverage);

}  // namespace sightline
