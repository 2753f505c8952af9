#include "formats/drive/look_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/text/table.h"

namespace sightline {
namespace {

constexpr std::string_view kNames[kLookSigns] = {"weak sigma",   "strong sigma", "scored share",
                                                 "score",        "nearest",      "moved along",
                                                 "moved across", "turned"};

}  // namespace

std::span<const std::string_view> look_sign_names() { return kNames; }

double doubt_of(const LookTest& test, const LookSigns& signs) {
  double doubt = test.constant;
  for (std::size_t i = 0; i < kLookSigns; ++i) doubt += test.weights[i] * signs[i];
  return doubt;
}

Result<void> validate(const LookPlan& plan) {
  SIGHTLINE_TRY(validate(plan.first));
  SIGHTLINE_TRY(validate(plan.second));
  const auto is_finite = [](double value) { return std::isfinite(value); };
  const bool is_usable = std::ranges::all_of(plan.test.weights, is_finite) &&
                         is_finite(plan.test.constant) && !std::isnan(plan.doubt_above) &&
                         is_finite(plan.limit_m) && plan.limit_m > 0.0;
  if (is_usable) return {};
  return Error{ErrorCode::kBadArgument,
               "a weight of the test, its threshold or the limit is no number, expected finite "
               "weights, a threshold that may be infinite, and a limit above 0",
               "", "a plan of looks"};
}

LookPlan plan_at(const LookPlan& plan, const Look& look) {
  LookPlan there = plan;
  const bool is_cheaper = !takes_every_return(look) && look.point_count > 0 &&
                          look.return_count <= plan.first.return_count &&
                          look.point_count < plan.first.point_count;
  if (is_cheaper) there.first = look;
  there.first.mode = LookMode::kSettle;
  return there;
}

std::string to_text(const LookPlan& plan) {
  return "from " + format_double(plan.limit_m) + " m: first " + to_text(plan.first) +
         "; where the test doubts it, " + to_text(plan.second);
}

}  // namespace sightline
