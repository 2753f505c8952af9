#include "formats/foreign/ros/bag_topics.h"

#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

constexpr std::int64_t kTenth_ns = 100'000'000;

StampedTransform moved(std::int64_t stamp_ns, const std::string& parent, const std::string& child,
                       double x_m) {
  StampedTransform transform{stamp_ns, parent, child, Pose::Identity()};
  transform.T_parent_child.translation().x() = x_m;
  return transform;
}

TransformTree driving() {
  TransformTree tree;
  for (int i = 0; i <= 10; ++i) tree.add(moved(i * kTenth_ns, "odom", "base_link", i), false);
  tree.add(moved(0, "base_link", "lidar", 0.5), true);
  return tree;
}

TEST(TransformTree, ComposesAtTheFastestTransform) {
  TransformTree tree = driving();
  tree.add(moved(0, "map", "odom", 100.0), false);
  tree.add(moved(10 * kTenth_ns, "map", "odom", 110.0), false);
  const std::vector<PoseRow> rows = value_of(tree.poses_of("lidar", "drive.mcap"));
  ASSERT_EQ(rows.size(), 11U);
  EXPECT_EQ(rows[3].stamp_ns, 3 * kTenth_ns);
  EXPECT_NEAR(rows[3].T_world_vehicle.translation().x(), 103.0 + 3.0 + 0.5, 1e-12);
}

TEST(TransformTree, EndsAtTheMapThatLiesOnEarth) {
  TransformTree tree = driving();
  tree.add(moved(0, "map", "odom", 100.0), false);
  tree.add(moved(0, "earth", "map", 6e6), true);
  const std::vector<PoseRow> rows = value_of(tree.poses_of("base_link", "drive.mcap"));
  EXPECT_EQ(rows.front().T_world_vehicle.translation().x(), 100.0);
}

TEST(TransformTree, LeavesOutTimesThatATransformDoesNotCover) {
  TransformTree tree = driving();
  tree.add(moved(2 * kTenth_ns, "map", "odom", 100.0), false);
  tree.add(moved(5 * kTenth_ns, "map", "odom", 100.0), false);
  EXPECT_EQ(tree.poses_of("base_link", "drive.mcap")->size(), 4U);
  // Later ones are too far away to say what was between.
  tree.add(moved(50 * kTenth_ns, "map", "odom", 100.0), false);
  EXPECT_EQ(tree.poses_of("base_link", "drive.mcap")->size(), 4U);
}

// Lidar and camera on one vehicle, the camera said again and again as older drivers do.
TEST(TransformTree, KnowsHowTwoFramesOfOneBodyLieToEachOther) {
  TransformTree tree = driving();
  StampedTransform camera = moved(0, "base_link", "camera", 2.0);
  camera.T_parent_child.linear() = Eigen::Quaterniond(0, 0, 0, 1).toRotationMatrix();  // looks back
  for (int i = 0; i < 3; ++i) {
    camera.stamp_ns = i * kTenth_ns;
    tree.add(camera, false);
  }
  tree.add(moved(0, "camera", "lens", 0.25), true);
  const std::optional<Pose> T_lidar_lens = tree.fixed_between("lidar", "lens");
  ASSERT_TRUE(T_lidar_lens.has_value());
  EXPECT_TRUE(T_lidar_lens->translation().isApprox(Eigen::Vector3d(1.25, 0, 0), 1e-12));
  EXPECT_TRUE(T_lidar_lens->linear().isApprox(camera.T_parent_child.linear(), 1e-12));
  const std::optional<Pose> T_lens_lidar = tree.fixed_between("lens", "lidar");
  ASSERT_TRUE(T_lens_lidar.has_value());
  EXPECT_TRUE((*T_lens_lidar * *T_lidar_lens).isApprox(Pose::Identity(), 1e-12));
  EXPECT_TRUE(tree.fixed_between("base_link", "lidar").has_value());
  EXPECT_FALSE(tree.fixed_between("odom", "lidar").has_value()) << "it moves";
  EXPECT_FALSE(tree.fixed_between("lidar", "nobody").has_value());
  camera.stamp_ns = 3 * kTenth_ns;
  camera.T_parent_child.translation().x() = 2.1;
  tree.add(camera, false);
  EXPECT_FALSE(tree.fixed_between("lidar", "lens").has_value()) << "the camera moves";
  tree = driving();
  tree.add(moved(0, "a", "b", 1.0), true);
  tree.add(moved(0, "b", "a", 1.0), true);
  EXPECT_TRUE(tree.fixed_between("a", "b").has_value());
  EXPECT_FALSE(tree.fixed_between("a", "lidar").has_value()) << "a circle";
}

TEST(TransformTree, TakesAStaticTransformOnceHoweverOftenItIsSaid) {
  TransformTree tree = driving();
  tree.add(moved(3 * kTenth_ns, "base_link", "lidar", 0.75), true);
  EXPECT_EQ(tree.fixed_pose("base_link", "lidar")->translation().x(), 0.75);
  EXPECT_FALSE(tree.fixed_pose("odom", "lidar").has_value());  // it moves
  EXPECT_FALSE(tree.fixed_pose("base_link", "camera").has_value());
}

TEST(TransformTree, RefusesWhatIsNoTree) {
  const auto code = [](const TransformTree& tree, const std::string& frame) {
    const Result<std::vector<PoseRow>> rows = tree.poses_of(frame, "drive.mcap");
    return rows ? ErrorCode{} : rows.error().code;
  };
  EXPECT_EQ(code(driving(), "camera"), ErrorCode::kNoPoses);
  EXPECT_EQ(code(TransformTree(), "base_link"), ErrorCode::kNoPoses);
  TransformTree still;
  still.add(moved(0, "map", "base_link", 1.0), false);
  EXPECT_EQ(code(still, "base_link"), ErrorCode::kNoPoses);
  TransformTree circle = driving();
  circle.add(moved(0, "lidar", "odom", 1.0), false);
  EXPECT_EQ(code(circle, "lidar"), ErrorCode::kMalformedPose);
  TransformTree two_parents = driving();
  two_parents.add(moved(0, "map", "base_link", 1.0), false);
  EXPECT_EQ(code(two_parents, "lidar"), ErrorCode::kMalformedPose);
}

}  // namespace
}  // namespace sightline
