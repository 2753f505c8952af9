#include "formats/annotation/factor_table.h"

#include <gtest/gtest.h>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

FactorTable small_table() {
  FactorTable table;
  table.looks = every_return_at({10.0, 20.0});
  table.factors = {"feature_count", "r_average"};
  table.site_count = 2;
  table.values = {1, 9.5, 2, 14.5, 0, 10, 3, 12.25};
  return table;
}

// The first factor is the same at both looks of a site.
FactorTable shared_table() {
  FactorTable table = small_table();
  table.shared_count = 1;
  table.values = {1, 9.5, 14.5, 3, 10, 12.25};
  return table;
}

ByFamily<FactorTable> table_with_samples() {
  FactorTable samples = shared_table();
  samples.looks = {{.range_m = 100.0, .return_count = 650, .point_count = 40},
                   {.range_m = 100.0, .return_count = 1944, .point_count = 80}};
  return {small_table(), samples};
}

TEST(FactorTable, SurvivesDisk) {
  expect_survives_disk(small_table());
  expect_survives_disk(shared_table());
  expect_survives_disk(table_with_samples());
}

TEST(FactorTable, FactorsThatLooksShareStandOnceAndAreReadAtEveryLook) {
  FactorTable apart = small_table();
  apart.values = {1, 9.5, 1, 14.5, 3, 10, 3, 12.25};
  EXPECT_EQ(dump(shared_table()).rows, dump(apart).rows);
  EXPECT_EQ(shared_table().values_per_site(), 3U);
}

TEST(FactorTable, InPiecesIsTheSameAndNoOtherPayloadIsTaken) {
  const ByFamily<FactorTable> table = table_with_samples();
  ByteWriter writer;
  encode(table, writer);
  const std::vector<std::byte> payload = writer.take();
  EXPECT_EQ(payload_size(table), payload.size());
  ByFamily<FactorTable> back;
  ASSERT_TRUE(open_payload(StoredBytes(payload), back));
  EXPECT_EQ(to_bytes(back), to_bytes(table));
  for (std::size_t size = 0; size < payload.size(); ++size) {
    ByFamily<FactorTable> cut;
    std::vector<std::byte> bytes = payload;
    bytes.resize(size);
    EXPECT_FALSE(open_payload(StoredBytes(std::move(bytes)), cut)) << size;
  }
  for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
    std::vector<std::byte> changed = payload;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    ByFamily<FactorTable> found;
    if (!open_payload(StoredBytes(std::move(changed)), found)) continue;
    EXPECT_TRUE(validate(found)) << bit;
  }
}

TEST(FactorTable, DumpsOneRowForEachSiteAndRange) {
  const Table text = dump(small_table());
  EXPECT_EQ(text.columns,
            (std::vector<std::string>{"site", "range_m", "look", "feature_count", "r_average"}));
  ASSERT_EQ(text.rows.size(), 4U);
  EXPECT_EQ(text.rows[3],
            (std::vector<Cell>{std::int64_t{1}, 20.0, std::string("20 m"), 3.0, 12.25}));
}

TEST(FactorTable, NamesTheFactorAndSiteThatAreNotFinite) {
  FactorTable table = small_table();
  table.values[5] = std::nan("");
  const Error error = failure_of(validate(table));
  EXPECT_EQ(error.message, "r_average is not finite");
  EXPECT_EQ(error.place, "site 1");
  FactorTable shared = shared_table();
  shared.values[3] = std::nan("");
  EXPECT_EQ(validate(shared).error().message, "feature_count is not finite");
  EXPECT_EQ(validate(shared).error().place, "site 1");
}

TEST(FactorTable, RefusesWhatContradictsItself) {
  expect_refused<FactorTable>(small_table(),
                              {[](FactorTable& equal) {
                                 equal.looks = every_return_at({20.0, 20.0});
                               },
                               [](FactorTable& equal) { equal.factors[1] = equal.factors[0]; },
                               [](FactorTable& fewer) { fewer.values.pop_back(); }});
  expect_refused<FactorTable>(shared_table(), {[](FactorTable& more) { more.shared_count = 3; }});
}

}  // namespace
}  // namespace sightline
