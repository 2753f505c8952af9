#include "formats/map/packed_model.h"

#include <gtest/gtest.h>

#include <vector>

#include "formats/base/random.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/handmade_model.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::vector<std::byte> payload_of(const PackedModel& model) {
  std::vector<std::byte> payload;
  EXPECT_TRUE(visit_payload(model, [&](std::span<const std::byte> piece) -> Result<void> {
    payload.insert(payload.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_EQ(payload.size(), payload_size(model));
  return payload;
}

TEST(PackedModel, KeepsTheBytesAndWhatTheRecordSays) {
  const ModelRecord record = random_map({.seed = 2, .model_size = 5000}).model;
  const PackedModel packed = value_of(pack_model(record));
  EXPECT_TRUE(packed.record.bytes.empty());
  PackedModel back;
  ASSERT_TRUE(open_payload(StoredBytes(payload_of(packed)), back));
  EXPECT_TRUE(back.record == packed.record);
  std::vector<std::byte> stored;
  const PackedBlock section = value_of(read_section(back, stored));
  EXPECT_TRUE(std::ranges::equal(value_of(checked_bytes(section)).bytes(), record.bytes));
  EXPECT_EQ(section.name, "error-model");
  EXPECT_EQ(section.version, record.encoding_version);
}

TEST(PackedModel, OfAStoredModelIsThatOfTheWhole) {
  const ErrorModel model =
      handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  const ModelRecord record = record_of(model);
  StoredErrorModel stored;
  ASSERT_TRUE(open_payload(StoredBytes(record.bytes), stored));
  const Result<PackedModel> packed = pack_model(stored);
  const Result<PackedModel> of_whole = pack_model(record);
  ASSERT_TRUE(packed && of_whole);
  EXPECT_TRUE(payload_of(*packed) == payload_of(*of_whole));
}

TEST(PackedModel, RefusesAnotherBlockAndEveryCut) {
  const PackedModel packed = value_of(pack_model(random_map({.seed = 3}).model));
  const std::vector<std::byte> payload = payload_of(packed);
  PackedModel back;
  for (std::size_t size = 0; size < payload.size(); ++size) {
    const std::vector<std::byte> cut(payload.begin(),
                                     payload.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(open_payload(StoredBytes(cut), back)) << size;
  }
  // The block is the last that there is.
  for (std::size_t i = payload.size() - packed.block.size(); i < payload.size(); ++i) {
    std::vector<std::byte> damaged = payload;
    damaged[i] ^= std::byte{4};
    EXPECT_FALSE(open_payload(StoredBytes(damaged), back)) << i;
  }
}

}  // namespace
}  // namespace sightline
