#include "formats/model/error_model.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "tests/support/artifact_checks.h"
#include "tests/support/handmade_model.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

ErrorModel small_model() {
  ErrorModel model = handmade_model({{{0.5, 0.75}, {0.2, 0.1}}, {{0.25, 1.0}, {0.4, 0.1}}}, 2);
  model.card.tree_count = 2;
  model.forest.trees.resize(2);
  model.forest.trees[1].nodes = {{0, 15.0F, 1, 4}, {0, 12.0F, 2, 3}};
  model.forest.rows = {20.0F, 10.0F, 13.0F, 20.0F};
  return model;
}

ErrorCode code_of(const ErrorModel& model) {
  const Result<void> valid = validate(model);
  return valid ? ErrorCode{} : valid.error().code;
}

TEST(ErrorModel, SurvivesTheDisk) { expect_survives_disk(small_model()); }

TEST(ErrorModel, IsRefusedWithAnyBitFlipped) {
  const std::vector<std::byte> bytes = to_bytes(small_model());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::byte> damaged = bytes;
      damaged[i] ^= std::byte(1 << bit);
      ASSERT_FALSE(from_bytes<ErrorModel>(damaged).has_value())
          << "bit " << bit << " of byte " << i;
    }
  }
}

TEST(ErrorModel, RefusesTreesThatAskForMoreThanIsThere) {
  ErrorModel many = small_model();
  many.forest.rows.pop_back();
  EXPECT_EQ(code_of(many), ErrorCode::kInvalidArtifact);
  EXPECT_FALSE(from_bytes<ErrorModel>(to_bytes(many)).has_value());
  ErrorModel unknown = small_model();
  unknown.forest.trees[1].nodes[1].feature = 9;
  EXPECT_FALSE(from_bytes<ErrorModel>(to_bytes(unknown)).has_value());
}

long peak_kib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// Sealed with a right checksum: any eight bytes might be a count.
TEST(ErrorModel, ThatPromisesMoreThanItHoldsIsRefusedBeforeItIsAllocated) {
  using Traits = ArtifactTraits<ErrorModel>;
  ByteWriter writer;
  encode(small_model(), writer);
  const std::vector<std::byte> payload = writer.take();
  const long before_kib = peak_kib();
  for (const std::uint64_t count :
       {std::uint64_t{1} << 29, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    for (std::size_t i = 0; i + sizeof count <= payload.size(); ++i) {
      std::vector<std::byte> damaged = payload;
      std::memcpy(damaged.data() + i, &count, sizeof count);
      const Result<ErrorModel> read =
          from_bytes<ErrorModel>(seal(Traits::kName, Traits::kVersion, std::move(damaged)));
      EXPECT_TRUE(!read || validate(*read)) << count << " at " << i;
    }
  }
  // 2^29 of anything take more than this.
  EXPECT_LT(peak_kib() - before_kib, 400L << 10);
}

TEST(ErrorModel, OfAnotherVersionIsRefusedAndSaysWhich) {
  ByteWriter writer;
  encode(small_model(), writer);
  const auto of_version = [&](std::uint32_t version) {
    return from_bytes<ErrorModel>(seal("error-model", version, writer.bytes())).error();
  };
  EXPECT_EQ(of_version(4).code, ErrorCode::kOldVersion);
  EXPECT_EQ(of_version(4).message, "a error-model of version 4, this program reads version 9");
  EXPECT_EQ(of_version(10).code, ErrorCode::kFutureVersion);
}

TEST(ErrorModel, NamesEveryRecordingInTextTableAndFacts) {
  const ErrorModel model = small_model();
  const std::string digest = to_hex(sha256("by hand"));
  EXPECT_NE(to_text(model).find("handmade  localization  by hand  " + digest), std::string::npos)
      << to_text(model);
  const Table table = recordings_table(model);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[1], (std::vector<Cell>{"handmade", "localization", "by hand", digest}));
  const std::pair<std::string, Cell> fact("sha256_of_localization_of_handmade", digest);
  const Table card = dump(model);
  EXPECT_NE(std::ranges::find(card.facts, fact), card.facts.end());
}

TEST(ErrorModel, WithBytesAppendedIsRefused) {
  std::vector<std::byte> bytes = to_bytes(small_model());
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(from_bytes<ErrorModel>(bytes));
}

TEST(ErrorModel, ReadsBackEveryTree) {
  const ErrorModel model = small_model();
  const ErrorModel back = value_of(from_bytes<ErrorModel>(to_bytes(model)));
  EXPECT_EQ(back.forest.trees, model.forest.trees);
  EXPECT_EQ(back.forest.labels, model.forest.labels);
}

TEST(ErrorModel, PrintsPredictionsBesideLabels) {
  ErrorModel model = small_model();
  model.sites[1].has_label = 0;  // dump asks nothing else
  const Table table = dump(model);
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.columns[7], "measured_mean_error_m");
  EXPECT_EQ(table.rows[0][7], Cell(0.2));
  EXPECT_EQ(table.rows[2][7], Cell(std::string()));
  EXPECT_EQ(table.rows[0].size(), table.columns.size());
  EXPECT_EQ(tables(model)[2].rows.size(), 2u);  // nodes
  EXPECT_EQ(tables(model)[3].rows.size(), 8u);  // a leaf for each label and tree
}

TEST(ErrorModel, RefusesTreesThatAreNone) {
  const auto with_nodes = [](std::vector<TreeNode> nodes) {
    ErrorModel model = small_model();
    model.forest.trees[1].nodes = std::move(nodes);
    return code_of(model);
  };
  EXPECT_EQ(with_nodes({{0, 15.0F, 1, 4}, {0, 12.0F, 2, 3}}), ErrorCode{});
  EXPECT_EQ(with_nodes({{0, 15.0F, 0, 4}, {0, 12.0F, 2, 3}}), ErrorCode::kInvalidArtifact);
  EXPECT_EQ(with_nodes({{0, 15.0F, 1, 9}, {0, 12.0F, 2, 3}}), ErrorCode::kInvalidArtifact);
  EXPECT_EQ(with_nodes({{0, 15.0F, 1, 2}, {0, 12.0F, 3, 4}}), ErrorCode::kInvalidArtifact);
  EXPECT_EQ(with_nodes({{0, 15.0F, 2, 3}, {0, 12.0F, 2, 3}}), ErrorCode::kInvalidArtifact);
  EXPECT_EQ(with_nodes({{1, 15.0F, 1, 4}, {0, 12.0F, 2, 3}}), ErrorCode::kInvalidArtifact);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(with_nodes({{0, kInfinity, 1, 4}, {0, 12.0F, 2, 3}}), ErrorCode::kInvalidArtifact);
}

TEST(ErrorModel, RefusesLabelsOutOfPlace) {
  ErrorModel empty_leaf = small_model();
  empty_leaf.forest.rows.assign(4, 10.0F);
  EXPECT_EQ(code_of(empty_leaf), ErrorCode::kInvalidArtifact);
  ErrorModel unsorted = small_model();
  std::swap(unsorted.forest.labels.front(), unsorted.forest.labels.back());
  EXPECT_EQ(code_of(unsorted), ErrorCode::kInvalidArtifact);
  ErrorModel fewer = small_model();
  fewer.sites[0].has_label = 0;
  EXPECT_EQ(code_of(fewer), ErrorCode::kInvalidArtifact);
}

TEST(ErrorModel, RefusesACardThatDoesNotFit) {
  ErrorModel other_count = small_model();
  other_count.card.tree_count = 3;
  EXPECT_EQ(code_of(other_count), ErrorCode::kInvalidArtifact);
  ErrorModel no_range = small_model();
  no_range.features[0].name = "crlb_max";
  EXPECT_EQ(code_of(no_range), ErrorCode::kInvalidArtifact);
  ErrorModel no_block = small_model();
  no_block.sites[1].block = 2;
  EXPECT_EQ(code_of(no_block), ErrorCode::kInvalidArtifact);
  ErrorModel unknown_data = small_model();
  unknown_data.card.places[0].recordings.cards[1].digest = {};
  EXPECT_EQ(code_of(unknown_data), ErrorCode::kInvalidArtifact);
  EXPECT_EQ(validate(unknown_data).error().place,
            "model card, place 'handmade', recording 'localization'");
  ErrorModel inverted = small_model();
  inverted.features[0].support_min[1] = 1.0;
  EXPECT_EQ(code_of(inverted), ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
