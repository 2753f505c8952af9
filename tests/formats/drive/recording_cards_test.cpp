#include "formats/drive/recording_cards.h"

#include <gtest/gtest.h>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

RecordingCards two_drives() {
  return {{{"mapping", "first", sha256("first")}, {"localization", "second", sha256("second")}}};
}

TEST(RecordingCards, SurviveTheDisk) { expect_survives_disk(two_drives()); }

TEST(RecordingCards, PrintDigestsAsSha256sumDoes) {
  // printf abc | sha256sum
  const RecordingCards recordings{{{"mapping", "first", sha256("abc")}}};
  EXPECT_EQ(
      dump(recordings).rows.at(0),
      (std::vector<Cell>{"mapping", "first",
                         "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"}));
}

TEST(RecordingCards, RefuseWhatNamesNoRecording) {
  const auto refusal = [](const RecordingCards& recordings) {
    const Result<void> valid = validate(recordings);
    if (valid) return std::string("accepted");
    EXPECT_EQ(valid.error().code, ErrorCode::kInvalidArtifact);
    return valid.error().place;
  };
  EXPECT_EQ(refusal({}), "");
  RecordingCards nameless = two_drives();
  nameless.cards[1].name.clear();
  EXPECT_EQ(refusal(nameless), "recording 'localization'");
  RecordingCards twice = two_drives();
  twice.cards[1].role = "mapping";
  EXPECT_EQ(refusal(twice), "recording 'mapping'");
  RecordingCards never_taken = two_drives();
  never_taken.cards[0].digest = {};
  EXPECT_EQ(refusal(never_taken), "recording 'mapping'");
}

}  // namespace
}  // namespace sightline
