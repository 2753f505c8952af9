#include "passes/model/promise/calibration_drives.h"

#include <gtest/gtest.h>

#include "passes/model/train_model.h"
#include "tests/formats/drive/identity/street_scans.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr int kScans = 6;
const SyntheticOptions kStreet = {.site_count = 300, .ranges_m = {10.0, 20.0}};

ErrorModel trained_on(const DrivenPlaces& places) {
  TestContext ctx(1);
  const TrainModelOptions few_trees = {.trees = 10};
  return value_of(train_model(ctx, few_trees, {places, {}})).ranges;
}

// The recordings of a place, whose names and digests no other place has.
RecordingCards recordings(int number, const std::vector<ScanPoints>& mapping,
                          const std::vector<ScanPoints>& localization) {
  const std::string name = std::to_string(number);
  RecordingCards cards{{card_of("map " + name, mapping), card_of("drive " + name, localization)}};
  cards.cards[1].role = "localization";
  return cards;
}

DrivenPlace place_with(const DrivenPlace& place, int number, RecordingCards cards) {
  DrivenPlace made = place;
  made.name = "place " + std::to_string(number);
  made.drives.resize(1);
  made.recordings = std::move(cards);
  return made;
}

CalibrationCount count_of(const DrivenPlaces& places) {
  const ErrorModel model = trained_on(places);
  return calibration_drives_of(model, CaseKind::kMapOnly).count;
}

TEST(CalibrationDrives, OneDriveAndNineCopiesOfItAreOnePlace) {
  const DrivenPlace place = place_driven_twice(1, kStreet);
  const std::vector<ScanPoints> mapping = street_scans({}, 0, kScans);
  const std::vector<ScanPoints> drive = street_scans({.noise = 2}, 0, kScans);
  DrivenPlaces places{{place_with(place, 0, recordings(0, mapping, drive))}};
  const CalibrationCount of_one = count_of(places);
  for (int copy = 1; copy < 10; ++copy) {
    std::vector<ScanPoints> again = drive;
    for (ScanPoints& scan : again) scan = with_noise(thinned(scan, 0.7, copy), 1e-3, copy);
    places.places.push_back(place_with(place, copy, recordings(copy, mapping, again)));
  }
  const CalibrationCount count = count_of(places);
  EXPECT_EQ(count.places, 1U);
  EXPECT_EQ(count.drives, of_one.drives);
  EXPECT_EQ(count.blocks, of_one.blocks);
  EXPECT_EQ(count.scope, PromiseScope::kThisDrive);
}

// Each map has axes of its own.
TEST(CalibrationDrives, TenDrivesOfOneStreetInFiveConfigurationsAreOnePlace) {
  const DrivenPlace place = place_driven_twice(1, kStreet);
  DrivenPlaces places;
  for (int i = 0; i < 5; ++i) {
    const auto seed = static_cast<std::uint64_t>(10 + 2 * i);
    DrivenPlace& again = places.places.emplace_back(
        place_with(place, i,
                   recordings(i, street_scans({.noise = seed}, 0, kScans),
                              street_scans({.noise = seed + 1}, 0, kScans))));
    Random random(seed);
    for (double& value : again.factors.values) value *= 1.0 + 0.05 * random.normal();
    again.sites.frame.origin_world_m += Eigen::Vector3d(0.0, 400.0 * i, 0.0);
  }
  const CalibrationCount of_one = count_of({{places.places[0]}});
  const CalibrationCount count = count_of(places);
  EXPECT_EQ(count.places, 1U);
  EXPECT_EQ(count.blocks, of_one.blocks);
}

}  // namespace
}  // namespace sightline
