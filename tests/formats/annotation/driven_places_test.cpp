#include "formats/annotation/driven_places.h"

#include <gtest/gtest.h>

#include "tests/support/artifact_checks.h"
#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

const SyntheticOptions kTiny = {
    .site_count = 2, .ranges_m = {10.0, 20.0}, .has_paper_factors = false};

TEST(DrivenPlaces, SurviveTheDisk) { expect_survives_disk(places_driven_twice(2, kTiny)); }

TEST(DrivenPlaces, PrintARowForEachDrive) {
  DrivenPlaces places = places_driven_twice(2, kTiny);
  places.places[1].drives[1].scan_of_site[0] = -1;
  const Table table = dump(places);
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[3][0], Cell(std::string("place 2")));
  EXPECT_EQ(table.rows[3][3], Cell(std::int64_t{1}));
}

TEST(DrivenPlaces, RefusePartsThatDoNotBelongTogether) {
  EXPECT_EQ(code_of(validate(DrivenPlaces())), ErrorCode::kNoTrainingRows);
  DrivenPlaces places = places_driven_twice(2, kTiny);
  places.places[1].recordings.cards.clear();
  EXPECT_EQ(code_of(validate(places)), ErrorCode::kInvalidArtifact);
  for (const auto& change : std::vector<std::function<void(std::vector<DrivenPlace>&)>>{
           [](std::vector<DrivenPlace>& all) { all[1].drives.clear(); },
           [](std::vector<DrivenPlace>& all) { all[0].drives[1].looks[1].range_m = 25.0; },
           [](std::vector<DrivenPlace>& all) { all[0].sites.sites.pop_back(); },
           [](std::vector<DrivenPlace>& all) { all[1].factors.factors[0] = "another"; }}) {
    places = places_driven_twice(2, kTiny);
    change(places.places);
    EXPECT_EQ(code_of(validate(places)), ErrorCode::kMismatchedInputs);
  }
  EXPECT_EQ(validate(places).error().place, "place 'place 2'");
}

}  // namespace
}  // namespace sightline
