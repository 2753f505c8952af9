#include "formats/base/result.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

Error failure() { return {ErrorCode::kBadValue, "no", "file", "line 1"}; }

Result<int> half_of(int number, int* calls = nullptr) {
  if (calls != nullptr) ++*calls;
  if (number % 2 != 0) return failure();
  return number / 2;
}

Result<void> check_even(int number) {
  SIGHTLINE_TRY(half_of(number));
  return {};
}

Result<std::string> quarter_of(int number, int* calls = nullptr) {
  SIGHTLINE_TRY(check_even(number));
  SIGHTLINE_ASSIGN(const int half, half_of(number, calls));
  int quarter = 0;
  SIGHTLINE_ASSIGN(quarter, half_of(half, calls));
  return std::to_string(quarter);
}

TEST(Try, GoesOnWithTheValueOrEndsWithTheError) {
  EXPECT_EQ(*quarter_of(12), "3");
  for (const int number : {1, 2, 7}) {
    const Error error = failure_of(quarter_of(number), number);
    EXPECT_EQ(error.code, ErrorCode::kBadValue);
    EXPECT_EQ(error.place, "line 1");
  }
}

TEST(Try, EvaluatesItsExpressionOnce) {
  int calls = 0;
  EXPECT_TRUE(quarter_of(12, &calls));
  EXPECT_EQ(calls, 2);
}

Result<std::unique_ptr<int>> boxed(int number) {
  if (number < 0) return failure();
  return std::make_unique<int>(number);
}

Result<int> unboxed(int number) {
  SIGHTLINE_ASSIGN(std::unique_ptr<int> box, boxed(number));
  return *box;
}

TEST(Try, MovesWhatCannotBeCopied) {
  EXPECT_EQ(*unboxed(5), 5);
  EXPECT_FALSE(unboxed(-5));
}

template <class Key, class Value>
Result<std::map<Key, Value>> map_of(Key key, Value value) {
  return std::map<Key, Value>{{key, value}};
}

// Commas of an expression, an `else`, and a stored Result, which stays as it is.
Result<std::size_t> sum_of_sizes(const Result<std::string>& stored, bool is_checked) {
  if (is_checked)
    SIGHTLINE_TRY(stored);
  else
    return 0;
  using Sizes = std::map<int, std::size_t>;
  SIGHTLINE_ASSIGN(const Sizes sizes, map_of<int, std::size_t>(1, stored->size()));
  SIGHTLINE_ASSIGN(const std::string copy, stored);
  return sizes.at(1) + copy.size();
}

TEST(Try, StandsWhereverAStatementDoes) {
  const Result<std::string> stored = std::string("abc");
  EXPECT_EQ(*sum_of_sizes(stored, true), 6U);
  EXPECT_EQ(*stored, "abc");
  EXPECT_EQ(*sum_of_sizes(failure(), false), 0U);
  EXPECT_FALSE(sum_of_sizes(failure(), true));
}

Error error_of(const Result<int>& result) {
  SIGHTLINE_TRY(result);
  return {};
}

TEST(Try, EndsAFunctionThatReturnsAnError) {
  EXPECT_EQ(error_of(failure()).code, ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline
