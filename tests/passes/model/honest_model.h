#pragma once

#include <algorithm>
#include <vector>

#include "formats/base/random.h"
#include "passes/model/choose_ranges.h"
#include "tests/support/handmade_model.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {

// A long route whose predictions are honest: a site with P misses with probability 1 - P.
inline ErrorModel honest_model(std::uint64_t seed, std::size_t block_count) {
  Random random(seed);
  std::vector<HandmadeSite> sites;
  double ease = 0.5;
  for (std::size_t i = 0; i < 60 * block_count; ++i) {
    ease = std::clamp(ease + random.uniform(-0.1, 0.1), 0.0, 1.0);
    HandmadeSite site;
    for (int range = 0; range < 5; ++range) {
      const double probability =
          std::clamp(0.3 * ease + 0.2 * (range + 1) + random.uniform(-0.1, 0.1), 0.0, 1.0);
      site.probability.push_back(probability);
      site.error_m.push_back(random.uniform() < probability ? 0.05 : 0.3);
    }
    sites.push_back(site);
  }
  ErrorModel model = handmade_model(sites, static_cast<std::uint32_t>(block_count));
  std::vector<double>& mean_m = model.out_of_fold.mean_m;
  for (std::size_t i = 0; i < mean_m.size(); ++i) {
    mean_m[i] = 0.3 - 0.25 * model.out_of_fold.within_probability[2 * i];
  }
  return model;
}

inline Result<RangeTable> choose(const ErrorModel& model, const ChooseRangesOptions& options,
                                 const PredictedError& predicted) {
  return of_ranges(choose_ranges(TestContext(), options, sites_of(model), predicted, model,
                                 demanding_factors(model)));
}

inline Result<RangeTable> choose(const ErrorModel& model, const ChooseRangesOptions& options) {
  return choose(model, options, model.out_of_fold);
}

inline ChooseRangesOptions with(RiskControl risk_control, double alpha = 0.05) {
  ChooseRangesOptions options;
  options.risk_control = risk_control;
  options.alpha = alpha;
  return options;
}

}  // namespace sightline
