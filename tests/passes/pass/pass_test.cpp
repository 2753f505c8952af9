#include "passes/pass/pass.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Stage, HasAName) {
  for (const Stage stage : kWorkStages) EXPECT_EQ(stage_named(stage_name(stage)), stage);
  EXPECT_EQ(stage_named("link"), Stage::kLink);
  EXPECT_EQ(stage_named("nothing"), std::nullopt);
}

}  // namespace
}  // namespace sightline
