#include "passes/matching/grid/packed_records.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

constexpr unsigned kLaneSets = 128;  // of seven lanes

KernelRecord random_record(unsigned used_lanes, Random& random) {
  float rows[kRecordRows][8] = {};
  for (float(&row)[8] : rows) {
    for (unsigned lane = 0; lane < 7; ++lane) {
      if ((used_lanes >> lane & 1u) == 0) continue;
      row[lane] = static_cast<float>(random.uniform(-1.0, 1.0) * std::exp2(random.uniform(0, 20)));
    }
  }
  KernelRecord record;
  static_assert(sizeof record == sizeof rows);
  std::memcpy(&record, rows, sizeof record);
  return record;
}

// The kernel's sum over lanes.
float tree_sum(std::span<const float> lanes) {
  float all[8] = {};
  std::ranges::copy(lanes, all);
  for (int count = 4; count > 0; count /= 2) {
    for (int i = 0; i < count; ++i) all[i] = all[2 * i] + all[2 * i + 1];
  }
  return all[0];
}

std::span<const float> row_of(const PackedRecords& records, std::size_t number, std::size_t row) {
  const std::size_t lanes = lane_count(records.places[number]);
  return {record_at(records.floats(), records.places[number]) + row * lanes, lanes};
}

TEST(PackedRecords, SumTheirLanesToTheBitsOfWholeRecords) {
  Random random(4);
  PackedRecords packed, whole;
  packed.reserve(20 * kLaneSets);
  for (unsigned i = 0; i < 20 * kLaneSets; ++i) {
    const KernelRecord record = random_record(i % kLaneSets, random);
    packed.append(record, i % kLaneSets);
    whole.append_whole(record);
  }
  for (std::size_t i = 0; i < packed.places.size(); ++i) {
    for (std::size_t row = 0; row < kRecordRows; ++row) {
      EXPECT_EQ(tree_sum(row_of(packed, i, row)), tree_sum(row_of(whole, i, row))) << i;
    }
  }
}

TEST(PackedRecords, HaveAsManyLanesAsNdsWhereThreeOrFewerAreUsed) {
  PackedRecords records;
  for (unsigned used = 0; used < kLaneSets; ++used) records.append(KernelRecord{}, used);
  for (unsigned used = 0; used < kLaneSets; ++used) {
    const auto count = static_cast<std::size_t>(std::popcount(used));
    const std::size_t lanes = lane_count(records.places[used]);
    EXPECT_GE(lanes, count);
    EXPECT_LE(lanes, 7u);
    if (count > 0 && count <= 3) {
      EXPECT_EQ(lanes, count) << used;
    }
  }
  EXPECT_EQ(lane_count(records.places[0]), 1u);
}

TEST(PackedRecords, HaveSevenFiniteFloatsBehindTheLast) {
  for (unsigned used = 0; used < kLaneSets; ++used) {
    PackedRecords records;
    for (unsigned i = 0; i <= used; ++i) records.append(KernelRecord{}, i);
    const KernelPlace last = records.places.back();
    const std::size_t end = kRecordRows * (last.begin + lane_count(last));
    const std::size_t size = records.memory.size() * sizeof(KernelRecord) / sizeof(float);
    ASSERT_GE(size, end + 7);
    for (std::size_t i = end; i < size; ++i) EXPECT_EQ(records.floats()[i], 0.0f);
  }
}

}  // namespace
}  // namespace sightline
