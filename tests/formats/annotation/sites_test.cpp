#include "formats/annotation/sites.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

Sites two_runs() {
  Sites sites;
  sites.frame.origin_world_m = {0.0, 64.0, 0.0};
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  sites.sites = {{0, 0.0, pose, {1.0, 2.0, 5.0}},
                 {0, 1.0, pose, {1.0, 2.0, 5.0}},
                 {1, 0.0, pose, {9.0, 2.0, 5.0}}};
  return sites;
}

TEST(Sites, SurviveTheDisk) { expect_survives_disk(two_runs()); }

TEST(Sites, ArePrintedWithTheSensorsOrigin) {
  const Table table = dump(two_runs());
  ASSERT_EQ(table.rows.size(), 3u);
  ASSERT_EQ(table.columns[5], "p_z_m");
  EXPECT_EQ(table.rows[1][0], Cell(std::int64_t{1}));
  EXPECT_EQ(table.rows[1][2], Cell(1.0));
  EXPECT_EQ(table.rows[1][5], Cell(5.0));
  EXPECT_EQ(table.rows[2][1], Cell(std::int64_t{1}));
}

TEST(Sites, RefuseADisorderedRoute) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  expect_refused<Sites>(two_runs(),
                        {[](Sites& backwards) { backwards.sites[1].s_m = 0.0; },
                         [](Sites& skipped_run) { skipped_run.sites[2].run = 2; },
                         [](Sites& late_start) { late_start.sites[2].s_m = 1.0; },
                         [](Sites& nowhere) { nowhere.sites[0].p_map_m.x() = kInfinity; },
                         [](Sites& no_spacing) { no_spacing.spacing_m = 0.0; }});
}

}  // namespace
}  // namespace sightline
