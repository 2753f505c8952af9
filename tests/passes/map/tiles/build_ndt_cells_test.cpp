#include "passes/map/tiles/build_ndt_cells.h"

#include <gtest/gtest.h>

#include "tests/support/test_context.h"
#include "tests/support/test_files.h"
#include "tests/support/toy_world.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// Of each third ND from one on, and a count that stands for what a part has.
NdtMap part_of(const NdtMap& map, std::size_t from) {
  NdtMap part = map;
  part.nds.clear();
  for (std::size_t i = from; i < map.nds.size(); i += 3) part.nds.push_back(map.nds[i]);
  part.sparse_cell_count = from;
  part.degenerate_cell_count = 10 * from;
  return part;
}

TEST(NdsByTile, AreTheMapThatTheirPartsMakeInAnyOrderInMemoryOrAFile) {
  NdtMap map = random_ndt_map(3, 3000, 300.0);
  map.sparse_cell_count = 3;
  map.degenerate_cell_count = 30;
  map.point_count = 77;
  for (const std::size_t most_in_memory : {std::size_t{100}, std::size_t{1} << 24}) {
    NdsByTile nds(map.cell_m, map.tile_m, most_in_memory);
    for (const std::size_t from : {2U, 0U, 1U}) nds.add(part_of(map, from));
    const NdtMap found = value_of(whole_rows(nds.take(map.frame, map.point_count)));
    EXPECT_TRUE(to_bytes(found) == to_bytes(map));
  }
}

TEST(NdsByTile, OfNothingAreNoNds) {
  NdsByTile nds(2.0, 64.0);
  EXPECT_EQ(nds.take({}, 0)->row_count(), 0U);
}

TEST(NdsByTile, SayThatTheDiskIsFull) {
  const NdtMap map = random_ndt_map(3, 300, 100.0);
  NdsByTile nds(map.cell_m, map.tile_m, 100);
  const NoLargeFiles full_disk;
  nds.add(map);
  const Error found = failure_of(nds.take(map.frame, 0));
  EXPECT_EQ(found.code, ErrorCode::kDiskFull);
  EXPECT_FALSE(found.file.empty());
}

}  // namespace
}  // namespace sightline
