#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"
#include "formats/evaluation/evaluation_scores.h"
#include "formats/evaluation/look_evaluation.h"
#include "formats/record/fields.h"

// How the ranges of a map fare on a drive. Coverage always stands beside time: a rule that misses
// the limit often is quick for that reason. Only sites where the drive has a scan are judged.
//
// Times are CPU times and differ from run to run; work (points x iterations) does not.

namespace sightline {

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
  std::vector<StreetScore> streets;
  // What figures along the route are drawn from.
  std::vector<JudgedSite> sites;                 // ascending
  std::vector<double> error_m;                   // [judged site][range]
  std::vector<double> time_ms;                   // [judged site][range]
  std::vector<std::uint8_t> chosen_range_index;  // [limit][rule][judged site]
  std::vector<LookEvaluation> of_samples;        // of the looks that take a sample: none or one

  [[nodiscard]] const RuleScore& score(std::size_t limit, Rule rule) const {
    return rules[limit * kRuleCount + static_cast<std::size_t>(rule)];
  }
  [[nodiscard]] std::size_t chosen(std::size_t limit, Rule rule, std::size_t judged) const {
    const std::size_t row = limit * kRuleCount + static_cast<std::size_t>(rule);
    return chosen_range_index[row * sites.size() + judged];
  }
};
SIGHTLINE_FIELDS(Evaluation, drive, reference, site_count, out_of_fold_count, stretch_m, limits_m,
                 statics, rules, reliability, streets, sites, error_m, time_ms, chosen_range_index,
                 of_samples)

template <>
struct ArtifactTraits<Evaluation> {
  static constexpr std::string_view kName = "evaluation";
  static constexpr std::uint32_t kVersion = 5;
};

Result<void> validate(const Evaluation& evaluation);
Table dump(const Evaluation& evaluation);  // the rules
// Rules, static ranges, types of street, reliability, errors at every range, and the sites with
// every rule's choice (schemas/evaluation.schema.json).
std::vector<Table> tables(const Evaluation& evaluation);

// For people: the paper's Tables I and II, every rule at every limit with the worst stretch and
// its place, types of street, and promised against observed coverage; aligned, with units.
std::string to_text(const Evaluation& evaluation);

}  // namespace sightline
