#include "passes/ingest/identify_recordings.h"

#include <gtest/gtest.h>

#include "formats/drive/shared_scans.h"
#include "tests/formats/drive/identity/street_scans.h"
#include "tests/support/test_context.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Drive drive_of(const std::string& name, const std::vector<ScanPoints>& scans) {
  Drive drive;
  drive.name = name;
  std::vector<Scan> stored;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ScanInfo info;
    info.recording_index = static_cast<std::uint32_t>(i);
    info.stamp_ns = static_cast<std::int64_t>(i) * 100'000'000;
    drive.scans.push_back(info);
    stored.push_back({info.stamp_ns, scans[i]});
  }
  drive.store = memory_scan_store(std::move(stored));
  return drive;
}

struct Identified {
  std::vector<std::string> warnings;
  Result<RecordingCards> cards;
};

Identified identified(const std::vector<Drive>& drives, const RecordingCards& cards) {
  Identified found{{}, Error{}};
  PassContext ctx = TestContext();
  ctx.warning_sink = [&](const std::string& message) { found.warnings.push_back(message); };
  std::vector<const Drive*> pointers;
  for (const Drive& drive : drives) pointers.push_back(&drive);
  found.cards = identify_recordings(ctx, {}, cards, pointers);
  return found;
}

const RecordingCards kTwo = {
    {{"mapping", "north", sha256("north")}, {"localization", "south", sha256("south")}}};

TEST(IdentifyRecordings, KeepsASketchOfEachScan) {
  const std::vector<ScanPoints> scans = street_scans({}, 0, 4);
  const std::vector<ScanPoints> others = street_scans({.noise = 2}, 0, 5);
  const Identified found = identified({drive_of("north", scans), drive_of("south", others)}, kTwo);
  const RecordingCards cards = value_of(found.cards);
  ASSERT_EQ(cards.cards[0].scans.size(), 4U);
  ASSERT_EQ(cards.cards[1].scans.size(), 5U);
  EXPECT_EQ(cards.cards[0].scans[2], sketch_of(scans[2]));
  EXPECT_TRUE(found.warnings.empty());
}

TEST(IdentifyRecordings, PassesOverFinishedMapsAndReleasedPoses) {
  const RecordingCards cards = {{{"map", "city", sha256("city")},
                                 {"base", "last", sha256("last")},
                                 {"localization", "south", sha256("south")}}};
  const RecordingCards found =
      value_of(identified({drive_of("south", street_scans({}, 0, 4))}, cards).cards);
  EXPECT_TRUE(found.cards[0].scans.empty());
  EXPECT_TRUE(found.cards[1].scans.empty());
  EXPECT_EQ(found.cards[2].scans.size(), 4U);
}

TEST(IdentifyRecordings, RefusesACopyUnderAnotherName) {
  const std::vector<ScanPoints> scans = street_scans({}, 0, 20);
  std::vector<ScanPoints> copies;
  for (std::size_t i = 5; i < scans.size(); ++i) copies.push_back(with_noise(scans[i], 1e-3, i));
  const Error error =
      failure_of(identified({drive_of("north", scans), drive_of("south", copies)}, kTwo).cards);
  EXPECT_EQ(error.code, ErrorCode::kBadValue);
  EXPECT_NE(error.message.find("15 of 15 scans of 'south' are copies of scans of mapping"),
            std::string::npos)
      << error.message;
}

TEST(IdentifyRecordings, WarnsOfARecordingOfWhichAPartIsKnown) {
  const std::vector<ScanPoints> scans = street_scans({}, 0, 10);
  std::vector<ScanPoints> longer = street_scans({.noise = 2}, 10, 20);
  longer.insert(longer.end(), scans.begin(), scans.end());
  const Identified found = identified({drive_of("north", scans), drive_of("south", longer)}, kTwo);
  EXPECT_TRUE(found.cards);
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_NE(found.warnings[0].find("10 of 30 scans"), std::string::npos) << found.warnings[0];
}

}  // namespace
}  // namespace sightline
