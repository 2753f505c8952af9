#include "passes/ingest/check_map_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "formats/foreign/clouds/pcd_writer.h"
#include "passes/ingest/ingest_map.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A street of 100 m: ground 16 m wide, houses 8 m high on both sides, posts; z up, metres.
std::vector<Eigen::Vector3d> street(bool has_other_side = true) {
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = 0.1; x_m < 100.0; x_m += 0.3) {
    for (double y_m = -7.9; y_m < 8.0; y_m += 0.3) points_m.emplace_back(x_m, y_m, 0.03);
    for (double z_m = 0.2; z_m < 8.0; z_m += 0.3) {
      points_m.emplace_back(x_m, -8.05, z_m);
      if (has_other_side) points_m.emplace_back(x_m, 8.05, z_m);
    }
  }
  for (double x_m = 5.2; x_m < 100.0; x_m += 9.0) {
    for (double z_m = 0.2; z_m < 6.0; z_m += 0.05) points_m.emplace_back(x_m, 4.0, z_m);
  }
  return points_m;
}

class CheckMapAxesTest : public testing::Test {
 protected:
  using Change = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;
  Result<SurfacePoints> ingest(const Change& change, bool has_other_side = true) {
    std::vector<PointXyzi> points;
    for (const Eigen::Vector3d& point_m : street(has_other_side)) {
      const Eigen::Vector3f changed = change(point_m).cast<float>();
      points.push_back({changed.x(), changed.y(), changed.z(), 0.0F});
    }
    EXPECT_TRUE(write_pcd_binary(folder_ / "map.pcd", points, IfExists::kReplace).has_value());
    return ingest_map(ctx_, {}, *open_point_map(folder_ / "map.pcd", 1));
  }
  std::string refusal(const Change& change) {
    const Error error = failure_of(ingest(change));
    EXPECT_EQ(error.code, ErrorCode::kUnsupportedFormat);
    return error.message;
  }
  ScratchFolder folder_;
  TestContext ctx_;
};

TEST_F(CheckMapAxesTest, AcceptsAStreetInMetresWithZUpHoweverItIsTurned) {
  EXPECT_TRUE(ingest([](const auto& p) -> Eigen::Vector3d { return p; }).has_value());
  EXPECT_TRUE(ingest([](const auto& p) { return Eigen::Vector3d(-p.y(), p.x(), p.z()); }));
  EXPECT_TRUE(ingest([](const auto& p) { return Eigen::Vector3d(p.x(), -p.y(), p.z() + 300.0); }));
  EXPECT_TRUE(ingest([](const auto& p) -> Eigen::Vector3d { return p; }, false)) << "one side";
}

TEST_F(CheckMapAxesTest, RefusesAMapWithAnotherAxisUpAndNamesIt) {
  EXPECT_THAT(refusal([](const auto& p) { return Eigen::Vector3d(p.x(), p.z(), -p.y()); }),
              HasSubstr("faces y"));
  EXPECT_THAT(refusal([](const auto& p) { return Eigen::Vector3d(p.x(), -p.z(), p.y()); }),
              HasSubstr("faces -y"));
  EXPECT_THAT(refusal([](const auto& p) { return Eigen::Vector3d(p.z(), p.x(), p.y()); }),
              HasSubstr("faces x"));
  EXPECT_THAT(refusal([](const auto& p) { return Eigen::Vector3d(p.x(), -p.y(), -p.z()); }),
              HasSubstr("faces -z"));
}

TEST_F(CheckMapAxesTest, RefusesMillimetresAndCentimetres) {
  EXPECT_THAT(refusal([](const auto& p) -> Eigen::Vector3d { return 1000.0 * p; }),
              HasSubstr("look like millimetres"));
  EXPECT_THAT(refusal([](const auto& p) -> Eigen::Vector3d { return 100.0 * p; }),
              HasSubstr("look like centimetres"));
}

}  // namespace
}  // namespace sightline
