#include "formats/model/error_model_at_rest.h"

#include <gtest/gtest.h>

#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

std::vector<std::byte> encoded(const ErrorModel& model) {
  ByteWriter writer;
  encode(model, writer);
  return writer.take();
}

ErrorModel model_of_both() {
  ErrorModel model = handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  model.of_samples.push_back(model);
  return model;
}

TEST(ErrorModelAtRest, KnowsTheCardAndHandsOverTheBytes) {
  const ErrorModel model = model_of_both();
  const std::vector<std::byte> bytes = encoded(model);
  EXPECT_EQ(payload_size(model), bytes.size());
  ErrorModelAtRest at_rest;
  ASSERT_TRUE(open_payload(StoredBytes(bytes), at_rest));
  EXPECT_EQ(card_facts(at_rest.head, at_rest.training_row_count),
            card_facts(model, model.forest.labels.size()));
  std::vector<std::byte> back;
  ASSERT_TRUE(visit_payload(at_rest, [&](std::span<const std::byte> piece) -> Result<void> {
    back.insert(back.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_TRUE(back == bytes);
  EXPECT_EQ(payload_size(at_rest), bytes.size());
}

TEST(ErrorModelAtRest, IsRefusedWhereItsHeadIsCut) {
  const std::vector<std::byte> bytes = encoded(model_of_both());
  ByteWriter head;
  encode_head(model_of_both(), head);
  ErrorModelAtRest at_rest;
  for (std::size_t size = 0; size < head.bytes().size() + sizeof(std::uint64_t); ++size) {
    const std::vector<std::byte> cut(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(open_payload(StoredBytes(cut), at_rest)) << size;
  }
}

}  // namespace
}  // namespace sightline
