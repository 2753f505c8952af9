#include "formats/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>

#include "formats/evaluation/evaluation_fields.h"

namespace sightline {
namespace {

Result<void> validate_shape(const Evaluation& evaluation) {
  const std::size_t pairs = evaluation.sites.size() * evaluation.statics.size();
  const std::size_t rule_count = evaluation.limits_m.size() * kRuleCount;
  if (evaluation.sites.empty() || evaluation.statics.empty() || evaluation.limits_m.empty()) {
    return invalid_artifact("an evaluation needs judged sites, ranges and limits", "");
  }
  if (evaluation.rules.size() != rule_count || evaluation.error_m.size() != pairs ||
      evaluation.time_ms.size() != pairs ||
      evaluation.chosen_range_index.size() != rule_count * evaluation.sites.size()) {
    return invalid_artifact("scores or choices do not fill the judged sites, ranges and limits",
                            "");
  }
  if (evaluation.out_of_fold_count > evaluation.sites.size() ||
      !std::isfinite(evaluation.stretch_m)) {
    return invalid_artifact("counts or the length of the worst stretch make no sense", "");
  }
  return {};
}

Result<void> validate_rules(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.rules.size(); ++i) {
    const RuleScore& score = evaluation.rules[i];
    const bool is_in_place = static_cast<std::size_t>(score.rule) == i % kRuleCount &&
                             score.limit_m == evaluation.limits_m[i / kRuleCount];
    const double shares[] = {score.coverage, score.unmet_share, score.extrapolated_share,
                             score.worst_coverage};
    const bool are_shares = std::all_of(std::begin(shares), std::end(shares),
                                        [](double share) { return share >= 0.0 && share <= 1.0; });
    if (!is_in_place || !are_shares || !is_finite(kRuleFields, score) ||
        score.worst_begin_site > score.worst_end_site ||
        score.worst_end_site >= evaluation.site_count) {
      return invalid_artifact("a score is out of place or makes no sense",
                              "rule " + std::to_string(i));
    }
  }
  return {};
}

Result<void> validate_sites(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.sites.size(); ++i) {
    const JudgedSite& site = evaluation.sites[i];
    const bool follows = i == 0 || evaluation.sites[i - 1].site < site.site;
    if (!follows || site.site >= evaluation.site_count || !is_finite(kSiteFields, site) ||
        static_cast<std::size_t>(site.street) >= kStreetTypeCount) {
      return invalid_artifact("a judged site is out of order or place",
                              "site " + std::to_string(i));
    }
  }
  for (const std::uint8_t index : evaluation.chosen_range_index) {
    if (index >= evaluation.statics.size()) {
      return invalid_artifact("a chosen range is not there", "");
    }
  }
  return {};
}

Result<void> validate_streets(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < evaluation.streets.size(); ++i) {
    const StreetScore& score = evaluation.streets[i];
    const bool is_known = static_cast<std::size_t>(score.rule) < kRuleCount &&
                          score.street != StreetType::kUnknown &&
                          static_cast<std::size_t>(score.street) < kStreetTypeCount;
    const bool are_shares = score.coverage >= 0.0 && score.coverage <= 1.0 &&
                            score.site_share > 0.0 && score.site_share <= 1.0;
    if (!is_known || !are_shares || score.site_count == 0 ||
        score.site_count > evaluation.sites.size() || !is_finite(kStreetFields, score)) {
      return invalid_artifact("the score of a type of street makes no sense",
                              "row " + std::to_string(i));
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const Evaluation& evaluation) {
  Result<void> valid = validate_shape(evaluation);
  if (valid) valid = validate_rules(evaluation);
  if (valid) valid = validate_sites(evaluation);
  if (valid) valid = validate_streets(evaluation);
  if (!valid) return valid;
  for (const StaticScore& score : evaluation.statics) {
    if (!is_finite(kStaticFields, score)) {
      return invalid_artifact("a static score is not finite", "");
    }
  }
  for (const ReliabilityBin& bin : evaluation.reliability) {
    if (!is_finite(kBinFields, bin)) return invalid_artifact("a reliability bin is not finite", "");
  }
  if (evaluation.of_samples.size() > 1) {
    return invalid_artifact("looks are judged more than once", "");
  }
  for (const LookEvaluation& looks : evaluation.of_samples) SIGHTLINE_TRY(validate(looks));
  return {};
}

void encode(const Evaluation& evaluation, ByteWriter& writer) {
  writer.put_string(evaluation.drive);
  writer.put(evaluation.reference);
  writer.put(evaluation.site_count);
  writer.put(evaluation.out_of_fold_count);
  writer.put(evaluation.stretch_m);
  writer.put_array(evaluation.limits_m);
  writer.put<std::uint64_t>(evaluation.statics.size());
  for (const StaticScore& score : evaluation.statics) put_numbers(kStaticFields, score, writer);
  writer.put<std::uint64_t>(evaluation.rules.size());
  for (const RuleScore& score : evaluation.rules) {
    writer.put(score.rule);
    put_numbers(kRuleFields, score, writer);
    writer.put(score.worst_begin_site);
    writer.put(score.worst_end_site);
  }
  writer.put<std::uint64_t>(evaluation.reliability.size());
  for (const ReliabilityBin& bin : evaluation.reliability) {
    put_numbers(kBinFields, bin, writer);
    writer.put(bin.count);
  }
  writer.put<std::uint64_t>(evaluation.sites.size());
  for (const JudgedSite& site : evaluation.sites) {
    writer.put(site.site);
    writer.put(site.run);
    put_numbers(kSiteFields, site, writer);
    writer.put(site.street);
  }
  writer.put<std::uint64_t>(evaluation.streets.size());
  for (const StreetScore& score : evaluation.streets) {
    writer.put(score.rule);
    writer.put(score.street);
    writer.put(score.site_count);
    put_numbers(kStreetFields, score, writer);
  }
  writer.put_array(evaluation.error_m);
  writer.put_array(evaluation.time_ms);
  writer.put_array(evaluation.chosen_range_index);
  writer.put(static_cast<std::uint8_t>(evaluation.of_samples.size()));
  for (const LookEvaluation& looks : evaluation.of_samples) encode(looks, writer);
}

void decode(ByteReader& reader, Evaluation& evaluation) {
  reader.get_string(evaluation.drive);
  reader.get(evaluation.reference);
  reader.get(evaluation.site_count);
  reader.get(evaluation.out_of_fold_count);
  reader.get(evaluation.stretch_m);
  reader.get_array(evaluation.limits_m);
  evaluation.statics.resize(reader.get_count(std::size(kStaticFields) * sizeof(double)));
  for (StaticScore& score : evaluation.statics) get_numbers(kStaticFields, reader, score);
  evaluation.rules.resize(reader.get_count(1 + std::size(kRuleFields) * sizeof(double) + 8));
  for (RuleScore& score : evaluation.rules) {
    reader.get(score.rule);
    if (static_cast<std::size_t>(score.rule) >= kRuleCount) return reader.fail();
    get_numbers(kRuleFields, reader, score);
    reader.get(score.worst_begin_site);
    reader.get(score.worst_end_site);
  }
  evaluation.reliability.resize(reader.get_count(std::size(kBinFields) * sizeof(double) + 4));
  for (ReliabilityBin& bin : evaluation.reliability) {
    get_numbers(kBinFields, reader, bin);
    reader.get(bin.count);
  }
  evaluation.sites.resize(reader.get_count(9 + std::size(kSiteFields) * sizeof(double)));
  for (JudgedSite& site : evaluation.sites) {
    reader.get(site.site);
    reader.get(site.run);
    get_numbers(kSiteFields, reader, site);
    reader.get(site.street);
  }
  evaluation.streets.resize(reader.get_count(6 + std::size(kStreetFields) * sizeof(double)));
  for (StreetScore& score : evaluation.streets) {
    reader.get(score.rule);
    reader.get(score.street);
    reader.get(score.site_count);
    get_numbers(kStreetFields, reader, score);
  }
  reader.get_array(evaluation.error_m);
  reader.get_array(evaluation.time_ms);
  reader.get_array(evaluation.chosen_range_index);
  const auto count = reader.get<std::uint8_t>();
  if (count > 1) return reader.fail();
  evaluation.of_samples.resize(reader.ok() ? count : 0);
  for (LookEvaluation& looks : evaluation.of_samples) decode(reader, looks);
}

}  // namespace sightline
