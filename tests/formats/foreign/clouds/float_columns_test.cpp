#include "formats/foreign/clouds/float_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(FloatColumns, AreTakenFromACountOrFromNames) {
  EXPECT_EQ(*parse_float_columns("4"), FloatColumns());
  EXPECT_EQ(*parse_float_columns("x y z intensity"), FloatColumns());
  EXPECT_EQ(*parse_float_columns("x, y, z, i"), FloatColumns());
  EXPECT_EQ(to_text(*parse_float_columns("3")), "x y z");
  EXPECT_EQ(to_text(*parse_float_columns("6")), "x y z intensity _ _");
  EXPECT_EQ(to_text(*parse_float_columns("t ring y x z reflectivity _ _")),
            "time _ y x z intensity _ _");
  EXPECT_EQ(*parse_float_columns(to_text(columns_of_count(7))), columns_of_count(7));
}

TEST(FloatColumns, RefuseWhatIsNoPoint) {
  for (const char* text : {"", "2", "65", "-4", "4.0", "xyz", "x y", "x y i", "x y z x",
                           "x y z i intensity", "x y z t time", "x y z ring ring"}) {
    const Error error = failure_of(parse_float_columns(text), text);
    EXPECT_EQ(error.code, ErrorCode::kBadValue) << text;
    EXPECT_THAT(error.message, testing::HasSubstr("x y z intensity ring"));
  }
}

}  // namespace
}  // namespace sightline
