#include "formats/map/map_file.h"

#include <gtest/gtest.h>

#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/test_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(MapFile, ThatShrankIsNotPrintedButAnError) {
  ShrinkingFile file(encode_map(random_map({.seed = 8})));
  const MapFile map{file.bytes(), {}};
  ASSERT_TRUE(dump(map));
  file.shrink();
  EXPECT_EQ(failure_of(dump(map)).code, ErrorCode::kCannotRead);
}

}  // namespace
}  // namespace sightline
