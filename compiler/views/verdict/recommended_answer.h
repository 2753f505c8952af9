#pragma once

#include <cstddef>
#include <string>

#include "compiler/views/verdict/answer_kind.h"
#include "formats/map/compiled_map.h"

namespace sightline {

// What the map answers at one place within one limit.
struct RecommendedAnswer {
  AnswerKind kind = AnswerKind::kRange;
  bool is_good = true;        // false: no look and no range is good enough; this is the best
  std::size_t choice = 0;     // index among the looks of the map, or its ranges
  double mean_error_m = 0.0;  // predicted
  double probability = 0.0;   // of an error within the limit
  friend bool operator==(const RecommendedAnswer&, const RecommendedAnswer&) = default;
};

// The recommended kind (LimitVerdict::recommended); the range where no look is good enough and a
// range is. A plan has the prediction of the look at that place.
RecommendedAnswer recommended_answer(const CompiledMap& map, AnswerKind recommended,
                                     std::size_t site, std::size_t limit);

// "plan", "100 m, 650 returns", "range 40 m", or "no good answer".
std::string answer_name(const CompiledMap& map, const RecommendedAnswer& answer);

}  // namespace sightline
