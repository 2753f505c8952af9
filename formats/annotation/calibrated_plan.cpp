#include "formats/annotation/calibrated_plan.h"

#include <string>

namespace sightline {

Result<void> validate(const CalibratedPlan& calibrated) {
  const auto is_share = [](double value) { return value >= 0.0 && value <= 1.0; };
  if (!is_share(calibrated.learnt_doubted_share) || !is_share(calibrated.doubted_share) ||
      calibrated.good_count > calibrated.scan_count) {
    return Error{ErrorCode::kInvalidArtifact, "counts or shares of a plan are out of range"};
  }
  if (!calibrated.plan) return {};
  const Result<void> valid = validate(*calibrated.plan);
  if (valid) return {};
  return Error{ErrorCode::kInvalidArtifact, valid.error().message, "", valid.error().place};
}

Table dump(const CalibratedPlan& calibrated) {
  Table table;
  table.name = "plan";
  table.facts = {{"scan_count", std::int64_t{calibrated.scan_count}},
                 {"good_count", std::int64_t{calibrated.good_count}},
                 {"learnt_doubted_share", calibrated.learnt_doubted_share},
                 {"doubted_share", calibrated.doubted_share}};
  if (!calibrated.plan) return table;
  const LookPlan& plan = *calibrated.plan;
  table.facts.emplace_back("limit_m", plan.limit_m);
  table.facts.emplace_back("first", to_text(plan.first));
  table.facts.emplace_back("second", to_text(plan.second));
  table.facts.emplace_back("doubt_above", plan.doubt_above);
  table.columns = {"sign", "weight"};
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    table.rows.push_back({std::string(look_sign_names()[i]), plan.test.weights[i]});
  }
  table.rows.push_back({std::string("constant"), plan.test.constant});
  return table;
}

}  // namespace sightline
