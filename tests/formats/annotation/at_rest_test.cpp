#include "formats/annotation/at_rest.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "tests/support/no_large_files.h"

// A whole table is the oracle of each: what is read or written some sites at a time has its rows
// and its bytes.

namespace sightline {
namespace {

std::vector<Look> two_looks() {
  return {{.range_m = 100.0, .return_count = 650, .point_count = 40},
          {.range_m = 100.0, .return_count = 1944, .point_count = 80}};
}

MeasuredError random_errors(std::size_t site_count, bool has_samples) {
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
  if (has_samples) {
    MeasuredError samples = measured;
    samples.looks = two_looks();
    fill(samples);
    measured.of_samples.push_back(std::move(samples));
  }
  fill(measured);
  return measured;
}

FactorTable random_factors(std::size_t site_count, bool has_samples) {
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
  FactorTable table = table_of(every_return_at({10.0, 20.0}), 0);
  if (has_samples) table.of_samples.push_back(table_of(two_looks(), 2));
  return table;
}

template <class X>
std::vector<std::byte> sealed(const AtRest<X>& table) {
  std::vector<std::byte> bytes;
  EXPECT_TRUE(visit_bytes(table, [&](std::span<const std::byte> piece) -> Result<void> {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return {};
  }));
  return bytes;
}

template <class X>
std::vector<std::byte> payload_of(const X& table) {
  ByteWriter writer;
  encode(table, writer);
  return writer.take();
}

template <class X>
void expect_same_as_whole(const X& whole) {
  const AtRest<X> rest = whole;
  ASSERT_TRUE(validate(rest));
  EXPECT_TRUE(sealed(rest) == to_bytes(whole));
  EXPECT_TRUE(to_bytes(*rest.whole()) == to_bytes(whole));
  EXPECT_EQ(payload_size(rest), payload_of(whole).size());
  EXPECT_EQ(dump(rest).rows, dump(whole).rows);
  const Result<AtRest<X>> back = from_stored<AtRest<X>>(StoredBytes(to_bytes(whole)));
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_TRUE(sealed(*back) == to_bytes(whole));
  EXPECT_TRUE(to_bytes(*back->whole()) == to_bytes(whole));
}

TEST(AtRest, HasTheBytesOfTheWholeAndGivesItBack) {
  for (const std::size_t site_count : {0U, 1U, 255U, 256U, 700U}) {
    for (const bool has_samples : {false, true}) {
      expect_same_as_whole(random_errors(site_count, has_samples));
      expect_same_as_whole(random_factors(site_count, has_samples));
    }
  }
}

TEST(AtRest, GivesAnySitesInARow) {
  const MeasuredError errors = random_errors(700, true);
  const FactorTable factors = random_factors(700, true);
  const AtRest<MeasuredError> errors_at_rest = errors;
  const AtRest<FactorTable> factors_at_rest = factors;
  for (const auto& [first, count] :
       {std::pair<std::size_t, std::size_t>{0, 1}, {0, 700}, {5, 300}, {699, 1}, {700, 0}}) {
    const MeasuredError some = *errors_at_rest.sites(first, count);
    const FactorTable of_factors = *factors_at_rest.sites(first, count);
    ASSERT_TRUE(validate(some));
    ASSERT_TRUE(validate(of_factors));
    ASSERT_EQ(some.scan_of_site.size(), count);
    ASSERT_EQ(of_factors.site_count, count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(some.scan_of_site[i], errors.scan_of_site[first + i]);
      EXPECT_EQ(some.row(i, 2).mean_m, errors.row(first + i, 2).mean_m);
      EXPECT_EQ(some.of_samples[0].row(i, 1).max_work,
                errors.of_samples[0].row(first + i, 1).max_work);
      EXPECT_EQ(of_factors.at(i, 1, 2), factors.at(first + i, 1, 2));
      EXPECT_EQ(of_factors.of_samples[0].at(i, 1, 2), factors.of_samples[0].at(first + i, 1, 2));
    }
  }
  MeasuredError ranges = errors;
  ranges.of_samples.clear();
  EXPECT_TRUE(to_bytes(*errors_at_rest.of_ranges(0, 700)) == to_bytes(ranges));
  EXPECT_TRUE(to_bytes(*errors_at_rest.of_samples(0, 700)) == to_bytes(errors.of_samples[0]));
}

// Every third site from the first on, from the second, from the third; and what is left is zero.
TEST(AtRest, IsWrittenInAnyOrderInMemoryOrAFile) {
  for (const std::size_t most_in_memory :
       {std::size_t{10}, SiteRowsWriter<FactorTable>::kMostInMemory}) {
    const FactorTable whole = random_factors(600, true);
    const AtRest<FactorTable> rest = whole;
    SiteRowsWriter<FactorTable> writer(rest.head(), most_in_memory);
    for (const std::size_t from : {2U, 0U, 1U}) {
      for (std::size_t first = from; first < 600; first += 3)
        writer.put(first, *rest.sites(first, 1));
    }
    EXPECT_TRUE(sealed(*writer.take()) == to_bytes(whole));
  }
  const MeasuredError whole = random_errors(600, true);
  const AtRest<MeasuredError> rest = whole;
  SiteRowsWriter<MeasuredError> writer(rest.head(), 10);
  const std::vector<std::size_t> sites = {599, 3, 4, 5, 300};
  MeasuredError some = *rest.sites(0, 5);
  writer.put(sites, some);
  const MeasuredError found = *writer.take()->whole();
  for (std::size_t i = 0; i < sites.size(); ++i) {
    EXPECT_EQ(found.row(sites[i], 1).mean_m, some.row(i, 1).mean_m);
    EXPECT_EQ(found.of_samples[0].row(sites[i], 1).mean_m, some.of_samples[0].row(i, 1).mean_m);
  }
  EXPECT_EQ(found.row(6, 1).mean_m, 0.0);
}

TEST(AtRest, SaysThatTheDiskIsFull) {
  const FactorTable whole = random_factors(600, true);
  const NoLargeFiles full_disk;
  SiteRowsWriter<FactorTable> writer(whole, 10);
  writer.put(0, whole);
  const Result<AtRest<FactorTable>> made = writer.take();
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kDiskFull);
  // Who has it whole needs no file.
  EXPECT_TRUE(validate(AtRest<FactorTable>(whole)));
}

template <class X>
void expect_refuses_what_the_whole_refuses(const X& table) {
  const std::vector<std::byte> payload = payload_of(table);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    std::vector<std::byte> cut = payload;
    cut.resize(size);
    AtRest<X> found;
    EXPECT_FALSE(open_payload(StoredBytes(std::move(cut)), found)) << size;
  }
  for (std::size_t bit = 0; bit < 8 * payload.size(); ++bit) {
    std::vector<std::byte> changed = payload;
    changed[bit / 8] ^= std::byte{1} << (bit % 8);
    X whole;
    AtRest<X> found;
    const bool is_whole = open_payload(StoredBytes(changed), whole).has_value();
    if (!open_payload(StoredBytes(changed), found)) continue;
    EXPECT_TRUE(is_whole) << bit;
    EXPECT_TRUE(to_bytes(*found.whole()) == to_bytes(whole)) << bit;
  }
}

TEST(AtRest, TakesNoPayloadThatIsNoTable) {
  expect_refuses_what_the_whole_refuses(random_errors(2, true));
  expect_refuses_what_the_whole_refuses(random_factors(3, true));
}

TEST(AtRest, SaysFromWhichSiteOnAValueIsWrong) {
  FactorTable table = random_factors(600, false);
  table.values[table.values_per_site() * 520] = std::numeric_limits<double>::infinity();
  const Result<void> valid = validate(AtRest<FactorTable>(table));
  ASSERT_FALSE(valid);
  EXPECT_EQ(valid.error().place, "from site 512 on, site 8");
}

TEST(MeasuredErrorInPieces, IsTheSameAndNoOtherPayloadIsTaken) {
  const MeasuredError table = random_errors(3000, true);
  std::vector<std::byte> pieces;
  ASSERT_TRUE(visit_payload(table, [&](std::span<const std::byte> piece) -> Result<void> {
    pieces.insert(pieces.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_TRUE(pieces == payload_of(table));
  EXPECT_EQ(payload_size(table), pieces.size());
  MeasuredError back;
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
