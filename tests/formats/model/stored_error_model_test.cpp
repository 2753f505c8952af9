#include "formats/model/stored_error_model.h"

#include <gtest/gtest.h>

#include "tests/support/handmade_model.h"

namespace sightline {
namespace {

std::vector<std::byte> encoded(const ByFamily<ErrorModel>& model) {
  ByteWriter writer;
  encode(model, writer);
  return writer.take();
}

ByFamily<ErrorModel> model_of_both() {
  const ErrorModel model =
      handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  return {model, model};
}

TEST(StoredErrorModel, KnowsTheCardAndHandsOverTheBytes) {
  const ByFamily<ErrorModel> model = model_of_both();
  const std::vector<std::byte> bytes = encoded(model);
  EXPECT_EQ(payload_size(model), bytes.size());
  StoredErrorModel stored;
  ASSERT_TRUE(open_payload(StoredBytes(bytes), stored));
  EXPECT_EQ(card_facts(stored.head, stored.training_row_count),
            card_facts(model.ranges, model.ranges.forest.labels.size()));
  std::vector<std::byte> back;
  ASSERT_TRUE(visit_payload(stored, [&](std::span<const std::byte> piece) -> Result<void> {
    back.insert(back.end(), piece.begin(), piece.end());
    return {};
  }));
  EXPECT_TRUE(back == bytes);
  EXPECT_EQ(payload_size(stored), bytes.size());
}

TEST(StoredErrorModel, IsRefusedWhereItsHeadIsCut) {
  const std::vector<std::byte> bytes = encoded(model_of_both());
  ByteWriter head;
  encode_head(model_of_both().ranges, head);
  StoredErrorModel stored;
  for (std::size_t size = 0; size < head.bytes().size() + sizeof(std::uint64_t); ++size) {
    const std::vector<std::byte> cut(bytes.begin(),
                                     bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(open_payload(StoredBytes(cut), stored)) << size;
  }
}

}  // namespace
}  // namespace sightline
