#include "compiler/views/verdict/recommended_answer.h"

#include <gtest/gtest.h>

#include "tests/formats/map/random_map.h"

namespace sightline {
namespace {

// The flags of look and range at site 3 within the first limit.
CompiledMap map_with(std::uint8_t look_flags, std::uint8_t range_flags) {
  CompiledMap map = random_map({.seed = 5});
  map.looks->ranges.flags[map.looks->ranges.shape().index(3, 0)] = look_flags;
  map.ranges.flags[map.ranges.shape().index(3, 0)] = range_flags;
  return map;
}

TEST(RecommendedAnswer, IsTheRecommendedKindWhereALookIsGoodEnough) {
  const CompiledMap map = map_with(0, kUnmet);
  for (const AnswerKind kind : {AnswerKind::kPlan, AnswerKind::kLook}) {
    const RecommendedAnswer answer = recommended_answer(map, kind, 3, 0);
    EXPECT_EQ(answer.kind, kind);
    EXPECT_TRUE(answer.is_good);
    EXPECT_EQ(answer.choice, map.looks->ranges.range(3, 0));
    EXPECT_EQ(answer.mean_error_m, map.looks->predicted.mean(3, answer.choice));
  }
  EXPECT_EQ(answer_name(map, recommended_answer(map, AnswerKind::kPlan, 3, 0)), "plan");
}

TEST(RecommendedAnswer, IsTheRangeWhereNoLookIsGoodEnough) {
  const CompiledMap map = map_with(kUnmet, 0);
  const RecommendedAnswer answer = recommended_answer(map, AnswerKind::kPlan, 3, 0);
  EXPECT_EQ(answer.kind, AnswerKind::kRange);
  EXPECT_TRUE(answer.is_good);
  EXPECT_EQ(answer.mean_error_m, map.predicted.mean(3, map.ranges.range(3, 0)));
  EXPECT_TRUE(answer_name(map, answer).starts_with("range "));
}

TEST(RecommendedAnswer, SaysWhereNeitherIsGoodEnough) {
  const CompiledMap map = map_with(kUnmet, kUnmet);
  for (const AnswerKind kind : {AnswerKind::kPlan, AnswerKind::kRange}) {
    const RecommendedAnswer answer = recommended_answer(map, kind, 3, 0);
    EXPECT_EQ(answer.kind, kind);
    EXPECT_FALSE(answer.is_good);
    EXPECT_EQ(answer_name(map, answer), "no good answer");
  }
}

}  // namespace
}  // namespace sightline
