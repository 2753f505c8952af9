#include "passes/localize/join_errors.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 12, .ranges_m = {10.0, 20.0}, .has_paper_factors = false};

Drive drive_with(const std::string& name, const std::string& sensor = "vlp-16") {
  Drive drive;
  drive.name = name;
  drive.sensor = *sensor_profile(sensor);
  return drive;
}

MeasuredError nowhere(MeasuredError measured) {
  std::ranges::fill(measured.scan_of_site, -1);
  std::ranges::fill(measured.rows, ErrorRow{});
  return measured;
}

struct Warned {
  PassContext ctx;
  std::vector<std::string> warnings;
  Warned() {
    ctx.warning_sink = [this](const std::string& message) { warnings.push_back(message); };
  }
};

template <class X>
std::vector<const X*> pointers_to(const std::vector<X>& all) {
  std::vector<const X*> pointers;
  for (const X& one : all) pointers.push_back(&one);
  return pointers;
}

Result<MeasuredDrives> join(PassContext& ctx, const std::vector<Drive>& drives,
                            const std::vector<ByFamily<MeasuredError>>& errors) {
  return join_errors(ctx, {}, pointers_to(drives), pointers_to(errors));
}

TEST(JoinErrors, KeepsEachDriveAsItIs) {
  const DrivenPlace place = place_driven_often(1, 3, kSmall);
  Warned warned;
  const MeasuredDrives three =
      value_of(join(warned.ctx, {drive_with("first"), drive_with("second"), drive_with("third")},
                    {place.drives[0], place.drives[1], place.drives[2]}));
  ASSERT_EQ(three.drives.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(to_bytes(three.drives[i].ranges), to_bytes(place.drives[i]));
  }
  EXPECT_EQ(three.numbers, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(warned.warnings.empty());
}

TEST(JoinErrors, LeavesOutWhoIsElsewhereOrHasAnotherSensorAndSaysSo) {
  const DrivenPlace place = place_driven_often(1, 4, kSmall);
  Warned warned;
  Drive raised = drive_with("raised");
  raised.sensor.T_vehicle_lidar.translation().z() += 0.5;
  const MeasuredDrives joined =
      value_of(join(warned.ctx,
                    {drive_with("first"), drive_with("far"), drive_with("other", "hdl-64e"), raised,
                     drive_with("last")},
                    {place.drives[0], nowhere(place.drives[1]), place.drives[2], place.drives[2],
                     place.drives[3]}));
  EXPECT_EQ(joined.numbers, (std::vector<std::uint32_t>{0, 4}));
  EXPECT_EQ(joined.named_count, 5u);
  ASSERT_EQ(warned.warnings.size(), 3u);
  EXPECT_NE(warned.warnings[0].find("drive 2, 'far', is left out: it has no scan near a site"),
            std::string::npos)
      << warned.warnings[0];
  EXPECT_NE(warned.warnings[1].find("'other', is left out: its sensor is hdl-64e"),
            std::string::npos)
      << warned.warnings[1];
  EXPECT_NE(warned.warnings[2].find("'raised', is left out: its sensor has another mounting"),
            std::string::npos)
      << warned.warnings[2];
}

TEST(JoinErrors, GoesOnWithoutTheFirst) {
  const DrivenPlace place = place_driven_often(1, 2, kSmall);
  Warned warned;
  const MeasuredDrives joined = value_of(join(warned.ctx, {drive_with("far"), drive_with("near")},
                                              {nowhere(place.drives[0]), place.drives[1]}));
  EXPECT_EQ(joined.numbers, std::vector<std::uint32_t>{1});
}

TEST(JoinErrors, RefusesErrorsOfOtherSites) {
  const DrivenPlace place = place_driven_often(1, 2, kSmall);
  const DrivenPlace longer = place_driven_often(
      1, 2, {.site_count = 13, .ranges_m = {10.0, 20.0}, .has_paper_factors = false});
  Warned warned;
  const Error refused = failure_of(
      join(warned.ctx, {drive_with("a"), drive_with("b")}, {place.drives[0], longer.drives[1]}));
  EXPECT_EQ(refused.code, ErrorCode::kMismatchedInputs);
}

TEST(PoolErrors, LetsTheDrivesSpeakInTurn) {
  DrivenPlace place = place_driven_often(1, 3, kSmall);
  place.drives[0].scan_of_site[0] = -1;  // the second speaks for it
  for (MeasuredError& drive : place.drives) drive.scan_of_site[5] = -1;
  for (MeasuredError& drive : place.drives) {
    for (std::size_t look = 0; look < 2; ++look) drive.rows[10 + look] = ErrorRow{};
  }
  const MeasuredDrives measured{{place.drives.begin(), place.drives.end()}, {0, 1, 2}, 3};
  const MeasuredError pooled = value_of(of_ranges(pool_errors(TestContext(), {}, measured)));
  ASSERT_TRUE(validate(pooled).has_value());
  EXPECT_EQ(pooled.drive, "synthetic, again, drive 3");
  const std::size_t speaker[] = {1, 1, 2, 0, 1, 9, 2, 0, 1, 2, 0, 1};
  for (std::size_t site = 0; site < 12; ++site) {
    if (speaker[site] == 9) {
      EXPECT_EQ(pooled.scan_of_site[site], -1);
      continue;
    }
    for (std::size_t look = 0; look < 2; ++look) {
      EXPECT_EQ(pooled.row(site, look).mean_m, place.drives[speaker[site]].row(site, look).mean_m)
          << site;
    }
  }
}

// As those that an earlier map contains.
TEST(PoolErrors, ForgetsTrackingStartsWhereADriveHasNone) {
  DrivenPlace place = place_driven_often(1, 2, kSmall);
  MeasuredError& tracked = place.drives[0];
  tracked.tracking_offsets.resize(3);
  tracked.tracking_ends.resize(3 * tracked.rows.size());
  const MeasuredDrives measured{{place.drives.begin(), place.drives.end()}, {0, 1}, 2};
  ASSERT_TRUE(validate(measured).has_value());
  const MeasuredError pooled = value_of(of_ranges(pool_errors(TestContext(), {}, measured)));
  EXPECT_TRUE(validate(pooled).has_value());
  EXPECT_TRUE(pooled.tracking_offsets.empty());
  place.drives[1].tracking_offsets.resize(2);
  place.drives[1].tracking_ends.resize(2 * tracked.rows.size());
  const MeasuredDrives others{{place.drives.begin(), place.drives.end()}, {0, 1}, 2};
  EXPECT_FALSE(validate(others).has_value()) << "from other starts";
}

TEST(PoolErrors, RefusesWhereNoDriveIsLeft) {
  EXPECT_EQ(failure_of(pool_errors(TestContext(), {}, {{}, {}, 2})).code, ErrorCode::kNoOverlap);
}

}  // namespace
}  // namespace sightline
