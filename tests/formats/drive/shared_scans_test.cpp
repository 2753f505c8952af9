#include "formats/drive/shared_scans.h"

#include <gtest/gtest.h>

#include "tests/formats/drive/identity/street_scans.h"

namespace sightline {
namespace {

constexpr int kScans = 10;

// The same recording, changed in the way number `variant`.
std::vector<ScanPoints> variant_of(const std::vector<ScanPoints>& scans, std::uint64_t variant) {
  std::vector<ScanPoints> changed;
  Random chance(variant);
  const bool is_noisy = chance.uniform() < 0.5;
  const bool is_thin = chance.uniform() < 0.5;
  const bool is_rounded = chance.uniform() < 0.5;
  const bool is_cropped = chance.uniform() < 0.3;
  const std::size_t first = chance.below(scans.size() / 2);
  for (std::size_t i = first; i < first + scans.size() / 2; ++i) {
    ScanPoints scan = scans[i];
    if (is_noisy) scan = with_noise(scan, 1e-3, mix(variant, i));
    if (is_thin) scan = thinned(scan, 0.5, mix(variant, i));
    if (is_rounded) scan = in_millimetres(scan);
    if (is_cropped) scan = cropped(scan, 25.0);
    changed.push_back(scan);
  }
  return changed;
}

TEST(SharedScans, RecognizeCopiesAndPartsInNinetyNineOfAHundredVariants) {
  const std::vector<ScanPoints> scans = street_scans({}, 0, 2 * kScans);
  const RecordingCard original = card_of("original", scans);
  const std::vector<ScanPoints> others = street_scans({.street = 9, .noise = 9}, 0, kScans / 2);
  int recognized = 0;
  for (std::uint64_t variant = 0; variant < 100; ++variant) {
    std::vector<ScanPoints> changed = variant_of(scans, variant);
    if (variant % 3 == 0) changed.insert(changed.end(), others.begin(), others.end());
    recognized += have_common_scans(original, card_of("copy", changed)) ? 1 : 0;
  }
  EXPECT_GE(recognized, 99);
}

TEST(SharedScans, AreNoneOfDifferentDrivesOfOneStreet) {
  const RecordingCard first = card_of("first", street_scans({}, 0, kScans));
  for (std::uint64_t drive = 2; drive < 10; ++drive) {
    const double lateral_m = drive % 2 == 0 ? 0.0 : 0.1 * static_cast<double>(drive);
    const RecordingCard other =
        card_of("other", street_scans({.noise = drive, .lateral_m = lateral_m}, 0, kScans));
    EXPECT_FALSE(have_common_scans(first, other)) << "drive " << drive;
    EXPECT_EQ(shared_count(first, other), 0U) << "drive " << drive;
  }
}

TEST(SharedScans, JoinRecordingsByWayOfOthers) {
  const std::vector<ScanPoints> north = street_scans({}, 0, kScans);
  const std::vector<ScanPoints> south = street_scans({.street = 2, .noise = 2}, 0, kScans);
  std::vector<ScanPoints> both = north;
  both.insert(both.end(), south.begin(), south.end());
  const RecordingCard cards[] = {card_of("north", north), card_of("other", street_scans({}, 90, 9)),
                                 card_of("south", south), card_of("both", both)};
  const RecordingCard* const all[] = {&cards[0], &cards[1], &cards[2], &cards[3]};
  EXPECT_EQ(recording_numbers(std::span(all).first(3)), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(recording_numbers(all), (std::vector<std::uint32_t>{0, 1, 0, 0}));
  EXPECT_EQ(shared_count(cards[3], cards[0]), static_cast<std::size_t>(kScans));
}

TEST(SharedScans, KnowRecordingsWithoutScansByTheirDigests) {
  const RecordingCard a{"mapping", "a", sha256("a")};
  const RecordingCard again{"localization", "again", sha256("a")};
  const RecordingCard b{"localization", "b", sha256("b")};
  EXPECT_TRUE(have_common_scans(a, again));
  EXPECT_FALSE(have_common_scans(a, b));
  EXPECT_TRUE(have_common_scans(again, RecordingCards{{b, a}}));
}

}  // namespace
}  // namespace sightline
