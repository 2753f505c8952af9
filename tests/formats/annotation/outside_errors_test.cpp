#include "formats/annotation/outside_errors.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

OutsideErrors some_errors() {
  OutsideErrors outside;
  outside.file = "my.csv";
  outside.localizer = {"my-ndt", 2, {{"leaf_m", "0.5"}}};
  outside.reference = ErrorReference::kFullRangeMatch;
  outside.errors = {{3, 10.0, 0, 0.05, 4}, {3, 10.0, 1, 0.07, 2}, {3, 20.0, 0, 0.01, 3}};
  return outside;
}

TEST(OutsideErrors, ReadBackWhatTheyWroteAndNoPartOfIt) {
  const std::vector<std::byte> bytes = to_bytes(some_errors());
  const OutsideErrors back = value_of(from_bytes<OutsideErrors>(bytes));
  EXPECT_EQ(to_bytes(back), bytes);
  EXPECT_EQ(back.file, "my.csv");
  EXPECT_EQ(back.localizer, some_errors().localizer);
  EXPECT_EQ(back.reference, ErrorReference::kFullRangeMatch);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(from_bytes<OutsideErrors>(std::span(bytes).first(size))) << size;
  }
  EXPECT_EQ(dump(back).rows.size(), 3u);
}

TEST(OutsideErrors, RefuseAtTheLineWhatCannotBe) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::function<void(OutsideErrors&)>, const char*>> kFaults = {
      {[&](OutsideErrors& e) { e.errors[1].error_m = kNan; }, "line 2"},
      {[](OutsideErrors& e) { e.errors[2].error_m = -0.1; }, "line 3"},
      {[](OutsideErrors& e) { e.errors[0].range_m = 0.0; }, "line 4"},
      {[](OutsideErrors& e) { e.errors[1].start = 0; }, "line 2"},
      {[](OutsideErrors& e) { e.errors[2].scan = 2; }, "line 3"},
      {[](OutsideErrors& e) { e.localizer.name = "my ndt"; }, "localizer"}};
  ASSERT_TRUE(validate(some_errors()));
  for (const auto& [spoil, place] : kFaults) {
    OutsideErrors spoilt = some_errors();
    spoil(spoilt);
    const Error error = failure_of(validate(spoilt), place);
    EXPECT_EQ(error.code, ErrorCode::kInvalidArtifact);
    EXPECT_EQ(error.place, place);
  }
}

}  // namespace
}  // namespace sightline
