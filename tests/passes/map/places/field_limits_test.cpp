#include "passes/map/places/field_limits.h"

#include <gtest/gtest.h>
#include <string>

namespace sightline {
namespace {

std::string refusal_of(std::size_t places, const ChooseFieldSitesOptions& options) {
  const Result<void> checked = check_places(places, options);
  if (checked) return "";
  EXPECT_EQ(checked.error().code, ErrorCode::kTooManyPlaces);
  return checked.error().message;
}

TEST(FieldLimits, AKilometreSquaredOfFreeGroundFitsAndFiveDoNot) {
  EXPECT_LT(memory_of_places_mib(250000), 2048.0);
  EXPECT_EQ(refusal_of(250000, {}), "");
  EXPECT_TRUE(check_ground(1e6, {}).has_value());
  EXPECT_NE(refusal_of(1250000, {}), "");
  const Error much = failure_of(check_ground(5e6, {}));
  EXPECT_EQ(much.code, ErrorCode::kTooManyPlaces);
  EXPECT_NE(much.message.find("5.0 km^2"), std::string::npos) << much.message;
}

TEST(FieldLimits, RefuseAsManyPlacesAsTheMemoryNamedDoesNotHold) {
  ChooseFieldSitesOptions options;
  options.memory_gib = (memory_of_places_mib(96) + 0.001) / 1024.0;
  EXPECT_EQ(refusal_of(96, options), "");
  options.memory_gib = (memory_of_places_mib(96) - 0.001) / 1024.0;
  EXPECT_NE(refusal_of(96, options).find("at most 95 fit in"), std::string::npos)
      << refusal_of(96, options);
  EXPECT_EQ(refusal_of(95, options), "");
  options.most_places = 96;  // whatever they take
  EXPECT_EQ(refusal_of(96, options), "");
  EXPECT_NE(refusal_of(97, options).find("at most 96 are allowed"), std::string::npos);
}

}  // namespace
}  // namespace sightline
