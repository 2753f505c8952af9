#include "compiler/config/place_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(PlaceNames, BeginBelowTheFolderThatHoldsAll) {
  EXPECT_THAT(place_names({"/data/north/town.yaml", "/data/south/town.yaml"}),
              ElementsAre("north/town.yaml", "south/town.yaml"));
  EXPECT_THAT(place_names({"/data/town.yaml", "/data/south/town.yaml"}),
              ElementsAre("town.yaml", "south/town.yaml"));
  EXPECT_THAT(place_names({"/data/north.yaml", "/date/south.yaml"}),
              ElementsAre("data/north.yaml", "date/south.yaml"));
  EXPECT_THAT(place_names({"/data/town.yaml"}), ElementsAre("town.yaml"));
  EXPECT_THAT(place_names({}), IsEmpty());
}

TEST(PlaceNames, DependNeitherOnWhereThatFolderLiesNorOnHowItIsWritten) {
  const std::vector<std::string> here = place_names({"north.yaml", "old/./town.yaml"});
  EXPECT_THAT(here, ElementsAre("north.yaml", "old/town.yaml"));
  EXPECT_EQ(place_names({"/a/b/c/north.yaml", "/a/b/../b/c/old/town.yaml"}), here);
}

}  // namespace
}  // namespace sightline
