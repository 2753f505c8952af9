#include "compiler/driver/known_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/driver/evaluate_plan.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/formats/drive/identity/street_scans.h"
#include "tests/support/handmade_model.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr int kScans = 20;

RecordingCard drive_of(const std::string& role, std::uint64_t noise) {
  RecordingCard card{role, "drive " + std::to_string(noise), sha256(std::to_string(noise)), {}};
  for (const ScanPoints& scan : street_scans({.noise = noise}, 0, kScans)) {
    card.scans.push_back(sketch_of(scan));
  }
  return card;
}

RecordingCard without_scans(RecordingCard card) {
  card.scans.clear();
  return card;
}

// The same scans in files of other bytes.
RecordingCard copy_of(RecordingCard card) {
  card.role = "evaluation";
  card.name = "copy";
  card.digest = sha256("copy of " + card.name);
  return card;
}

CompiledMap map_of(const std::vector<RecordingCard>& cards,
                   const std::vector<RecordingCard>& trained) {
  CompiledMap map = route_map(10);
  map.recordings.reset();
  if (!cards.empty()) map.recordings = RecordingCards{cards};
  ErrorModel model = handmade_model({{{0.5, 0.9}, {0.2, 0.05}}, {{0.5, 0.9}, {0.2, 0.05}}}, 2);
  model.card.places.front().recordings.cards = trained;
  map.model = record_of(ByFamily<ErrorModel>(model));
  return map;
}

// What a drive that the configuration does not list is to a map.
KnownDrive known(const RecordingCard& drive, const CompiledMap& map) {
  CompileConfig config;
  config.mapping.scans = "mapping";
  config.evaluation.scans = "evaluation";
  const EvaluatePlan evaluate = evaluate_plan(config, map);
  ArtifactSet artifacts;
  artifacts.provide(evaluate.identified, RecordingCards{{drive}});
  return value_of(known_drive(map, config, evaluate, artifacts));
}

const RecordingCard kMapping = drive_of("mapping", 1);
const RecordingCard kLocalization = drive_of("localization", 2);
const RecordingCard kTrained = drive_of("mapping", 3);
const RecordingCard kOther = drive_of("evaluation", 4);

TEST(KnownDrive, IsWhatMadeTheMapItsErrorsOrItsModel) {
  const CompiledMap map = map_of({kMapping, kLocalization}, {kTrained});
  const KnownDrive made = known(copy_of(kMapping), map);
  EXPECT_EQ(made.origin, DriveOrigin::kKnown);
  EXPECT_EQ(made.why,
            "20 of 20 scans of 'copy' are copies of scans of 'drive 1', which made the map");
  const KnownDrive measured = known(copy_of(kLocalization), map);
  EXPECT_EQ(measured.origin, DriveOrigin::kKnown);
  EXPECT_THAT(measured.why, HasSubstr("whose errors were measured in the map"));
  const KnownDrive trained = known(copy_of(kTrained), map);
  EXPECT_EQ(trained.origin, DriveOrigin::kKnown);
  EXPECT_THAT(trained.why, HasSubstr("on which the map's model was trained"));
  EXPECT_EQ(known(kOther, map).origin, DriveOrigin::kOther);
}

// Maps and models of earlier programs list no scans, or no recordings.
TEST(KnownDrive, IsOfUnknownOriginWhereMapOrModelListsNoScans) {
  const KnownDrive no_cards = known(kOther, map_of({}, {kTrained}));
  EXPECT_EQ(no_cards.origin, DriveOrigin::kUnknown);
  EXPECT_EQ(no_cards.why, "the map does not list the scans it was made from");
  const KnownDrive no_scans =
      known(kOther, map_of({without_scans(kMapping), without_scans(kLocalization)}, {kTrained}));
  EXPECT_EQ(no_scans.origin, DriveOrigin::kUnknown);
  const KnownDrive no_scans_of_model =
      known(kOther, map_of({kMapping, kLocalization}, {without_scans(kTrained)}));
  EXPECT_EQ(no_scans_of_model.origin, DriveOrigin::kUnknown);
  EXPECT_EQ(no_scans_of_model.why,
            "the map's model does not list the scans that it was trained on");
}

}  // namespace
}  // namespace sightline
