#include "formats/map/map_file.h"

#include <gtest/gtest.h>

#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/shrinking_file.h"

namespace sightline {
namespace {

TEST(MapFile, ThatShrankIsNotPrintedButAnError) {
  ShrinkingFile file(encode_map(random_map({.seed = 8})));
  const MapFile map{file.bytes(), {}};
  ASSERT_TRUE(dump(map));
  file.shrink();
  const Result<Table> printed = dump(map);
  ASSERT_FALSE(printed);
  EXPECT_EQ(printed.error().code, ErrorCode::kCannotRead);
}

}  // namespace
}  // namespace sightline
