#include "passes/localize/calibrate_plan.h"

#include <gtest/gtest.h>

#include "passes/pass/default_looks.h"
#include "tests/passes/localize/mapped_street.h"
#include "tests/support/artifact_checks.h"
#include "tests/support/kept_parts.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

CalibratePlanOptions half_metre_voxels() {
  CalibratePlanOptions options;
  options.matching.leaf_m = 0.5;
  return options;
}

Result<CalibratedPlan> calibrate(const CalibratePlanOptions& options,
                                 const ByFamily<RangeTable>& ranges, int threads = 1) {
  return calibrate_plan(TestContext(threads), options, street().second.drive, street().second.truth,
                        street().map, street().sites, ranges);
}

// By its first look alone.
TriedScan tried(double doubt, double error_m) { return {doubt, {error_m, 0.0}, {}, {}, {}}; }

std::vector<TriedScan> good_looks() {
  std::vector<TriedScan> looks;
  for (int i = 1; i <= 100; ++i) looks.push_back(tried(0.01 * i, 0.02));
  return looks;
}

TEST(CalibratePlan, DoubtsFewOfTheGoodLooks) {
  LookPlan plan = usual_plan();
  CalibratePlanOptions options;
  EXPECT_NEAR(raised_threshold(options, plan, good_looks()), 0.98, 1e-12);
  options.doubted_share = 0.0;
  EXPECT_NEAR(raised_threshold(options, plan, good_looks()), 1.0, 1e-12);
  options.doubted_share = 1.0;
  EXPECT_NEAR(raised_threshold(options, plan, good_looks()), 0.01, 1e-12);
  plan.doubt_above = 0.5;
  EXPECT_EQ(raised_threshold(options, plan, good_looks()), 0.5) << "never below the learnt one";
}

TEST(CalibratePlan, LetsNoLookBeyondTheLimitPass) {
  const LookPlan plan = usual_plan();
  std::vector<TriedScan> looks = good_looks();
  looks.push_back(tried(0.40, 0.08));  // neither good nor beyond the limit
  EXPECT_NEAR(raised_threshold({}, plan, looks), 0.98, 1e-12);
  looks.push_back(tried(0.30, 0.11));
  looks.push_back(tried(0.60, 0.50));
  EXPECT_LT(raised_threshold({}, plan, looks), 0.30);
  EXPECT_GT(raised_threshold({}, plan, looks), 0.299);
  looks.push_back(tried(-3.0, 0.50));
  EXPECT_EQ(raised_threshold({}, plan, looks), plan.doubt_above) << "what was learnt stands";
}

TEST(CalibratePlan, LearnsNothingFromAFewScans) {
  const std::vector<TriedScan> all = good_looks();
  const LookPlan plan = usual_plan();
  EXPECT_EQ(raised_threshold({}, plan, {all.begin(), all.begin() + 9}), plan.doubt_above);
  EXPECT_GT(raised_threshold({}, plan, {all.begin(), all.begin() + 10}), plan.doubt_above);
}

TEST(CalibratePlan, IsDearerWhereLooksHoldAsMuchForLess) {
  const LookPlan plan = usual_plan();
  const double doubted = plan.doubt_above + 1.0;
  const double certain = plan.doubt_above - 1.0;
  const TriedScan twice{doubted, {0.02, 100.0}, {0.02, 400.0}, {0.02, 1000.0}, {0.02, 300.0}};
  const TriedScan once{certain, {0.02, 100.0}, {0.02, 400.0}, {0.02, 1000.0}, {0.02, 300.0}};
  std::vector<TriedScan> scans(10, twice);
  EXPECT_TRUE(is_dearer_than_looks(plan, scans)) << "1000 against 300";
  EXPECT_FALSE(is_dearer_than_looks(plan, {scans.begin(), scans.begin() + 9})) << "too few scans";
  EXPECT_FALSE(is_dearer_than_looks(plan, std::vector<TriedScan>(10, once))) << "100 against 300";
  std::fill_n(scans.begin(), 7, once);
  EXPECT_FALSE(is_dearer_than_looks(plan, scans)) << "370 against 300: up to half more is allowed";
  scans[6] = twice;
  EXPECT_TRUE(is_dearer_than_looks(plan, scans)) << "460 against 300";
  LookPlan cheaper = plan;
  cheaper.second = cheaper_second_look();
  EXPECT_FALSE(is_dearer_than_looks(cheaper, scans)) << "220 against 300";
  scans[9].look.error_m = 2.0 * plan.limit_m;
  EXPECT_FALSE(is_dearer_than_looks(plan, scans)) << "a look that misses";
  scans[8].with_own.error_m = 2.0 * plan.limit_m;
  EXPECT_TRUE(is_dearer_than_looks(plan, scans)) << "where the plan misses as often";
}

TEST(CalibratePlan, TakesTheCheaperSecondLookWhereItIsAsGoodForDoubtedScans) {
  const LookPlan plan = usual_plan();
  const auto doubted = [&](double by_cheaper_m, double by_own_m) {
    return TriedScan{plan.doubt_above + 1.0, {}, {by_cheaper_m, 0.0}, {by_own_m, 0.0}, {}};
  };
  std::vector<TriedScan> scans(20, doubted(0.02, 0.02));
  EXPECT_TRUE(is_cheaper_as_good({}, plan, scans));
  EXPECT_FALSE(is_cheaper_as_good({}, plan, {scans.begin(), scans.begin() + 19})) << "too few";
  scans[3] = doubted(0.06, 0.04);
  EXPECT_FALSE(is_cheaper_as_good({}, plan, scans)) << "it misses 5 cm once";
  scans[4] = doubted(0.04, 0.06);
  EXPECT_TRUE(is_cheaper_as_good({}, plan, scans)) << "the plan's own misses as often";
  for (TriedScan& scan : scans) scan.doubt = plan.doubt_above;
  EXPECT_FALSE(is_cheaper_as_good({}, plan, scans)) << "none is doubted";
}

TEST(CalibratePlan, MatchesEveryScanFromWhereTheTwoBeforeItForetellIt) {
  const CalibratedPlan calibrated = value_of(calibrate(half_metre_voxels(), ranges_with_looks({})));
  ASSERT_TRUE(calibrated.plan);
  EXPECT_TRUE(validate(calibrated));
  expect_survives_disk(calibrated);
  EXPECT_EQ(calibrated.scan_count, 16U) << "all but the first two of 18";
  ASSERT_GE(calibrated.good_count, 10U);
  EXPECT_EQ(calibrated.learnt_doubted_share, 0.0) << "every box has even walls";
  EXPECT_EQ(calibrated.plan, usual_plan()) << "and so what was learnt in towns holds here";
  const CalibratedPlan again = value_of(calibrate(half_metre_voxels(), ranges_with_looks({}), 3));
  EXPECT_EQ(to_bytes(again), to_bytes(calibrated)) << "whatever the number of threads";
}

TEST(CalibratePlan, FindsAgainWhatDependsOnNothingNew) {
  KeptParts kept;
  const auto calibrated = [&](const TestDrive& drive, const NdtMap& map,
                              const ByFamily<RangeTable>& ranges) {
    PassContext ctx = kept.context();
    return to_bytes(*calibrate_plan(ctx, half_metre_voxels(), drive.drive, drive.truth, map,
                                    street().sites, ranges));
  };
  const TestDrive& drive = street().second;
  const std::vector<std::byte> first = calibrated(drive, street().map, ranges_with_looks({}));
  EXPECT_EQ(kept.made().size(), 1U);
  TestDrive renamed = drive;
  renamed.drive.name = "another";
  EXPECT_EQ(calibrated(renamed, street().map, ranges_with_looks({})), first);
  EXPECT_TRUE(kept.made().empty());
  TestDrive moved = drive;
  moved.truth.poses[3].T_map_vehicle.translation().x() += 0.01;
  calibrated(moved, street().map, ranges_with_looks({}));
  EXPECT_EQ(kept.made().size(), 1U);
  TestDrive later = drive;
  later.drive.scans[5].stamp_ns += 1;
  calibrated(later, street().map, ranges_with_looks({}));
  EXPECT_EQ(kept.made().size(), 1U);
  NdtMap other = street().map;
  other.nds.front().mean_m.z() += 0.001;
  calibrated(drive, other, ranges_with_looks({}));
  EXPECT_EQ(kept.made().size(), 1U);
}

TEST(CalibratePlan, HasNoPlanWithoutLooks) {
  const CalibratedPlan calibrated = value_of(calibrate(half_metre_voxels(), street().ranges));
  EXPECT_FALSE(calibrated.plan);
  EXPECT_TRUE(validate(calibrated));
  expect_survives_disk(calibrated);
}

TEST(CalibratePlan, RefusesWhatDoesNotBelongTogether) {
  ByFamily<RangeTable> fewer = ranges_with_looks({});
  fewer.ranges.site_count = 3;
  EXPECT_EQ(failure_of(calibrate(half_metre_voxels(), fewer)).code, ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
