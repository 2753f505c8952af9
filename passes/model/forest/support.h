#pragma once

#include <cstddef>
#include <vector>

#include "formats/model/error_model.h"

namespace sightline {

// Whether a model can speak for a site at a range: of what its forest decides by, how much lies
// where training was? A feature weighs what its importance is (of out-of-fold predictions); range_m
// and features that help nothing weigh nothing. It lies outside where it is beyond the extremes
// that training saw at this range by more than a margin, a share of their spread.
class Support {
 public:
  Support(const ErrorModel& model, double margin);

  // Of the weight, the share that lies outside; 0 where no feature weighs anything. `row`: the
  // model's features at the range of this index.
  [[nodiscard]] double outside_share(const float* row, std::size_t range) const;
  // More than half.
  [[nodiscard]] bool is_outside(const float* row, std::size_t range) const;

 private:
  const ErrorModel& model_;
  double margin_;
  std::vector<double> weights_;  // [feature], sum 1 or 0
};

}  // namespace sightline
