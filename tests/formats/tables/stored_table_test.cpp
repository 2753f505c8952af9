#include "formats/tables/stored_table.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/base/random.h"
#include "formats/tables/stored_table_writer.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/test_files.h"
#include "tests/support/value_of.h"

// A whole table is the oracle of each: what is read or written some sites at a time has its rows
// and its bytes.

namespace sightline {
namespace {

std::vector<Look> two_looks() {
  return {{.range_m = 100.0, .return_count = 650, .point_count = 40},
          {.range_m = 100.0, .return_count = 1944, .point_count = 80}};
}

ByFamily<MeasuredError> random_errors(std::size_t site_count, bool has_samples) {
  Random random(site_count + 1);
  MeasuredError measured;
  measured.drive = "morning";
  measured.looks = every_return_at({10.0, 20.0, 30.0});
  measured.offsets = {{0.25, 0.5, -0.1, 0.01}};
  for (std::size_t site = 0; site < site_count; ++site) {
    measured.scan_of_site.push_back(site % 7 == 3 ? -1 : static_cast<std::int64_t>(2 * site));
  }
  const auto fill = [&](MeasuredError& table) {
    table.rows.resize(table.shape().size(site_count));
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (table.scan_of_site[table.shape().site_of(i)] < 0) continue;
      table.rows[i].mean_m = random.uniform(0.0, 1.0);
      table.rows[i].max_work = random.uniform(0.0, 1e6);
      table.rows[i].point_count = static_cast<std::uint32_t>(i);
    }
  };
  ByFamily<MeasuredError> both(measured);
  if (has_samples) {
    both.samples = measured;
    both.samples->looks = two_looks();
    fill(*both.samples);
  }
  fill(both.ranges);
  return both;
}

ByFamily<FactorTable> random_factors(std::size_t site_count, bool has_samples) {
  Random random(site_count + 1);
  const auto table_of = [&](std::vector<Look> looks, std::uint32_t shared_count) {
    FactorTable table;
    table.looks = std::move(looks);
    table.factors = {"feature_count", "r_average", "own_error"};
    table.site_count = static_cast<std::uint32_t>(site_count);
    table.shared_count = shared_count;
    table.values.resize(site_count * table.values_per_site());
    for (double& value : table.values) value = random.uniform(-1.0, 1.0);
    return table;
  };
  ByFamily<FactorTable> both(table_of(every_return_at({10.0, 20.0}), 0));
  if (has_samples) both.samples = table_of(two_looks(), 2);
  return both;
}

template <class X>
void expect_same_as_whole(const ByFamily<X>& whole) {
  using Stored = ByFamily<StoredTable<X>>;
  const Stored stored = whole;
  ASSERT_TRUE(validate(stored));
  EXPECT_TRUE(sealed(stored) == to_bytes(whole));
  EXPECT_TRUE(to_bytes(*whole_of(stored)) == to_bytes(whole));
  EXPECT_EQ(payload_size(stored), payload_of(whole).size());
  EXPECT_EQ(dump(stored)->rows, dump(whole).rows);
  const Stored back = value_of(from_stored<Stored>(StoredBytes(to_bytes(whole))));
  EXPECT_TRUE(sealed(back) == to_bytes(whole));
  EXPECT_TRUE(to_bytes(*whole_of(back)) == to_bytes(whole));
}

TEST(StoredTable, HasTheBytesOfTheWholeAndGivesItBack) {
  for (const std::size_t site_count : {0U, 1U, 255U, 256U, 700U}) {
    for (const bool has_samples : {false, true}) {
      expect_same_as_whole(random_errors(site_count, has_samples));
      expect_same_as_whole(random_factors(site_count, has_samples));
    }
  }
}

TEST(StoredTable, GivesAnyConsecutiveRows) {
  const MeasuredError errors = random_errors(700, false).ranges;
  const FactorTable factors = *random_factors(700, true).samples;
  const StoredTable<MeasuredError> stored_errors = errors;
  const StoredTable<FactorTable> stored_factors = factors;
  for (const auto& [first, count] :
       {std::pair<std::size_t, std::size_t>{0, 1}, {0, 700}, {5, 300}, {699, 1}, {700, 0}}) {
    const MeasuredError some = *stored_errors.rows(first, count);
    const FactorTable of_factors = *stored_factors.rows(first, count);
    ASSERT_TRUE(validate(some));
    ASSERT_TRUE(validate(of_factors));
    ASSERT_EQ(some.scan_of_site.size(), count);
    ASSERT_EQ(of_factors.site_count, count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(some.scan_of_site[i], errors.scan_of_site[first + i]);
      EXPECT_EQ(some.row(i, 2).mean_m, errors.row(first + i, 2).mean_m);
      EXPECT_EQ(some.row(i, 1).max_work, errors.row(first + i, 1).max_work);
      EXPECT_EQ(of_factors.at(i, 1, 2), factors.at(first + i, 1, 2));
    }
  }
}

// Every third site from the first on, from the second, from the third; and what is left is zero.
TEST(StoredTable, IsWrittenInAnyOrderInMemoryOrAFile) {
  for (const std::size_t most_in_memory :
       {std::size_t{10}, StoredTableWriter<FactorTable>::kMostInMemory}) {
    const FactorTable whole = *random_factors(600, true).samples;
    const StoredTable<FactorTable> stored = whole;
    StoredTableWriter<FactorTable> writer(stored.head(), most_in_memory);
    for (const std::size_t from : {2U, 0U, 1U}) {
      for (std::size_t first = from; first < 600; first += 3)
        writer.put(first, *stored.rows(first, 1));
    }
    EXPECT_TRUE(sealed(*writer.take()) == to_bytes(whole));
  }
  const MeasuredError whole = random_errors(600, false).ranges;
  const StoredTable<MeasuredError> stored = whole;
  StoredTableWriter<MeasuredError> writer(stored.head(), 10);
  const std::vector<std::size_t> sites = {599, 3, 4, 5, 300};
  MeasuredError some = *stored.rows(0, 5);
  writer.put(sites, some);
  const MeasuredError found = *writer.take()->whole();
  for (std::size_t i = 0; i < sites.size(); ++i) {
    EXPECT_EQ(found.row(sites[i], 1).mean_m, some.row(i, 1).mean_m);
  }
  EXPECT_EQ(found.row(6, 1).mean_m, 0.0);
}

TEST(StoredTable, ReturnsThatTheDiskIsFull) {
  const FactorTable whole = random_factors(600, false).ranges;
  const NoLargeFiles full_disk;
  StoredTableWriter<FactorTable> writer(whole, 10);
  writer.put(0, whole);
  const Result<StoredTable<FactorTable>> made = writer.take();
  EXPECT_EQ(code_of(made), ErrorCode::kDiskFull);
  // One made of a whole needs no file.
  EXPECT_TRUE(validate(StoredTable<FactorTable>(whole)));
}

TEST(StoredTable, OfAFileThatShrankIsNotPrintedButAnError) {
  ShrinkingFile file(to_bytes(random_factors(600, false).ranges));
  const Result<StoredTable<FactorTable>> stored =
      from_stored<StoredTable<FactorTable>>(file.bytes());
  ASSERT_TRUE(stored && dump(*stored));
  file.shrink();
  EXPECT_EQ(code_of(dump(*stored)), ErrorCode::kCannotRead);
}

TEST(ByFamily, HasSamplesAtTheSameSites) {
  ByFamily<FactorTable> table = random_factors(3, false);
  table.samples = random_factors(2, true).samples;
  EXPECT_EQ(failure_of(validate(table)).place, "samples");
}

template <class X>
void expect_refuses_what_the_whole_refuses(const ByFamily<X>& table) {
  const std::vector<std::byte> payload = payload_of(table);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    std::vector<std::byte> cut = payload;
    cut.resize(size);
    ByFamily<StoredTable<X>> found;
    EXPECT_FALSE(open_payload(StoredBytes(std::move(cut)), found)) << size;
  }
  for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
    std::vector<std::byte> changed = payload;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    ByFamily<X> whole;
    ByFamily<StoredTable<X>> found;
    const bool is_whole = open_payload(StoredBytes(changed), whole).has_value();
    if (!open_payload(StoredBytes(changed), found)) continue;
    EXPECT_TRUE(is_whole) << bit;
    EXPECT_TRUE(to_bytes(*whole_of(found)) == to_bytes(whole)) << bit;
  }
}

TEST(StoredTable, RefusesEveryCutAndNoOtherPayloadThanTheWholeDoes) {
  expect_refuses_what_the_whole_refuses(random_errors(2, true));
  expect_refuses_what_the_whole_refuses(random_factors(3, true));
}

TEST(StoredTable, NamesTheSitesAmongWhichAValueIsWrong) {
  FactorTable table = random_factors(600, false).ranges;
  table.values[table.values_per_site() * 520] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(failure_of(validate(StoredTable<FactorTable>(table))).place,
            "from site 512 on, site 8");
}

TEST(MeasuredErrorInPieces, HasTheSameBytesAndRefusesEveryCut) {
  const ByFamily<MeasuredError> table = random_errors(3000, true);
  std::vector<std::byte> pieces;
  ASSERT_TRUE(visit_payload(table, [&](std::span<const std::byte> piece) -> Result<void> {
    pieces.insert(pieces.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_TRUE(pieces == payload_of(table));
  EXPECT_EQ(payload_size(table), pieces.size());
  ByFamily<MeasuredError> back;
  ASSERT_TRUE(open_payload(StoredBytes(pieces), back));
  EXPECT_TRUE(to_bytes(back) == to_bytes(table));
  const std::vector<std::byte> small = payload_of(random_errors(2, true));
  for (std::size_t size = 0; size < small.size(); ++size) {
    std::vector<std::byte> cut = small;
    cut.resize(size);
    EXPECT_FALSE(open_payload(StoredBytes(std::move(cut)), back)) << size;
  }
}

}  // namespace
}  // namespace sightline
