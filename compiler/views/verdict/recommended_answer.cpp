#include "compiler/views/verdict/recommended_answer.h"

#include "formats/text/numbers.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

bool is_unmet(const RangeTable& table, std::size_t site, std::size_t limit) {
  return (table.flags_of(site, limit) & kUnmet) != 0;
}

RecommendedAnswer answer_of_table(const RangeTable& table, const PredictedError& predicted,
                                  std::size_t site, std::size_t limit) {
  RecommendedAnswer answer;
  answer.is_good = !is_unmet(table, site, limit);
  answer.choice = table.range(site, limit);
  answer.mean_error_m = predicted.mean(site, answer.choice);
  answer.probability = predicted.probability(site, answer.choice, limit);
  return answer;
}

}  // namespace

RecommendedAnswer recommended_answer(const CompiledMap& map, AnswerKind recommended,
                                     std::size_t site, std::size_t limit) {
  const bool is_by_look =
      recommended != AnswerKind::kRange &&
      (!is_unmet(map.looks->ranges, site, limit) || is_unmet(map.ranges, site, limit));
  if (!is_by_look) return answer_of_table(map.ranges, map.predicted, site, limit);
  RecommendedAnswer answer = answer_of_table(map.looks->ranges, map.looks->predicted, site, limit);
  answer.kind = recommended;
  return answer;
}

std::string answer_name(const CompiledMap& map, const RecommendedAnswer& answer) {
  if (!answer.is_good) return "no good answer";
  if (answer.kind == AnswerKind::kPlan) return "plan";
  if (answer.kind == AnswerKind::kLook) return to_text(map.looks->ranges.looks[answer.choice]);
  return concat("range ", format_double(map.ranges.looks[answer.choice].range_m), " m");
}

}  // namespace sightline
