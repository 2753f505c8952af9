#include "formats/annotation/measured_drives.h"

#include <gtest/gtest.h>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

MeasuredError drive_of(const std::string& name, double error_m) {
  MeasuredError measured;
  measured.drive = name;
  measured.matching.localizer.name = "searching";
  measured.looks = every_return_at({10.0, 20.0});
  measured.scan_of_site = {7, -1};
  measured.rows.resize(4);
  measured.rows[0].mean_m = measured.rows[1].mean_m = error_m;
  return measured;
}

MeasuredDrives two_of_three() {
  return {{drive_of("monday", 0.1), drive_of("wednesday", 0.2)}, {0, 2}, 3};
}

TEST(MeasuredDrives, SurviveDisk) { expect_survives_disk(two_of_three()); }

TEST(MeasuredDrives, DumpARowForEachDrive) {
  const Table table = dump(two_of_three());
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(std::get<std::int64_t>(table.rows[1][0]), 2);
  EXPECT_EQ(std::get<std::string>(table.rows[1][1]), "wednesday");
  EXPECT_EQ(std::get<std::int64_t>(table.rows[1][3]), 1);
}

TEST(MeasuredDrives, KeepTheCardsOfThoseThatWereNotLeftOut) {
  const RecordingCards cards{{{"mapping", "a", sha256("a")},
                              {"localization", "monday", sha256("b")},
                              {"localization[2]", "tuesday", sha256("c")},
                              {"localization[3]", "wednesday", sha256("d")},
                              {"evaluation", "e", sha256("e")}}};
  std::vector<std::string> names;
  for (const RecordingCard& card : without_left_out(cards, two_of_three()).cards) {
    names.push_back(card.name);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"a", "monday", "wednesday", "e"}));
}

TEST(MeasuredDrives, RefuseWhatIsNotOfOneMap) {
  expect_refused<MeasuredDrives>(
      two_of_three(),
      {[](MeasuredDrives& looks) { looks.drives[1].ranges.looks[1].range_m = 30.0; },
       [](MeasuredDrives& sites) {
         sites.drives[1].ranges.scan_of_site.push_back(-1);
         sites.drives[1].ranges.rows.resize(6);
       },
       [](MeasuredDrives& measured) {
         measured.drives[1].ranges.matching.localizer.name = "plain";
       }});
}

TEST(MeasuredDrives, RefuseNumbersThatAreNotTheirs) {
  for (const std::vector<std::uint32_t>& numbers :
       {std::vector<std::uint32_t>{0}, {1, 1}, {2, 0}, {0, 3}}) {
    MeasuredDrives measured = two_of_three();
    measured.numbers = numbers;
    EXPECT_EQ(code_of(validate(measured)), ErrorCode::kInvalidArtifact);
  }
}

}  // namespace
}  // namespace sightline
