#include "passes/ingest/odd_scans.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <numbers>

#include "formats/base/random.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

using testing::Each;
using testing::ElementsAre;

// A street of posts at random places, seen every metre.
class OddScansTest : public testing::Test {
 protected:
  static constexpr std::size_t kScans = 30;

  static std::vector<Eigen::Vector3d> posts(std::uint64_t seed) {
    Random random(seed);
    std::vector<Eigen::Vector3d> posts_m;
    for (int i = 0; i < 300; ++i) {
      posts_m.emplace_back(random.uniform(-30.0, 60.0), random.uniform(-25.0, 25.0), 0.0);
    }
    return posts_m;
  }
  static Pose pose_of(std::size_t scan, double yaw_rad = 0.0) {
    Pose pose = Pose::Identity();
    pose.translate(Eigen::Vector3d(1.13 * static_cast<double>(scan), 0.0, 0.0));
    pose.rotate(rotation_matrix({Eigen::Vector3d::UnitZ(), yaw_rad}));
    return pose;
  }
  static TopView seen(const Pose& T_world_lidar, std::uint64_t place = 1) {
    PointCloudFile cloud;
    for (const Eigen::Vector3d& post_m : posts(place)) {
      cloud.points_m.emplace_back(T_world_lidar.inverse() * post_m);
    }
    return {cloud, SensorProfile()};
  }
  OddScansTest() {
    for (std::size_t i = 0; i < kScans; ++i) views_.push_back(seen(pose_of(i)));
  }
  void turn(std::size_t scan, double yaw_rad) { views_[scan] = seen(pose_of(scan, yaw_rad)); }
  std::vector<std::size_t> odd() {
    if (poses_.empty()) poses_.resize(views_.size());
    const std::vector<bool> is_odd = odd_scans(views_, poses_, 2);
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < is_odd.size(); ++i) {
      if (is_odd[i]) numbers.push_back(i);
    }
    return numbers;
  }

  std::vector<TopView> views_;
  std::vector<std::optional<Pose>> poses_;
};

TEST_F(OddScansTest, FindsScansThatAreTurnedRoundOrOfAnotherPlace) {
  turn(4, std::numbers::pi);
  views_[12] = seen(pose_of(12), /*place=*/2);
  turn(20, std::numbers::pi);
  turn(21, std::numbers::pi);
  EXPECT_THAT(odd(), ElementsAre(4, 12, 20, 21));
}

TEST_F(OddScansTest, FindsOneInFive) {
  for (std::size_t i = 2; i < kScans; i += 5) turn(i, std::numbers::pi);
  EXPECT_THAT(odd(), ElementsAre(2, 7, 12, 17, 22, 27));
}

TEST_F(OddScansTest, FindsTheFirstAndTheLastOfADrive) {
  turn(0, std::numbers::pi);
  turn(kScans - 1, std::numbers::pi);
  EXPECT_THAT(odd(), ElementsAre(0, kScans - 1));
}

TEST_F(OddScansTest, KeepsScansOfASensorThatSwingsThereAndBackAndOfOneThatStaysTurned) {
  turn(10, 1.2);
  for (std::size_t i = 20; i < kScans; ++i) turn(i, std::numbers::pi);
  EXPECT_TRUE(odd().empty());
}

TEST_F(OddScansTest, KeepsScansThatAreFarApartByTheirPosesAndScansWhosePoseIsWrong) {
  views_.clear();
  for (std::size_t i = 0; i < 10; ++i) {
    views_.push_back(seen(pose_of(6 * i)));
    poses_.emplace_back(pose_of(6 * i));
  }
  EXPECT_TRUE(odd().empty());
  poses_.clear();
  views_.clear();
  for (std::size_t i = 0; i < kScans; ++i) {
    views_.push_back(seen(pose_of(i)));
    poses_.emplace_back(pose_of(i));
  }
  *poses_[15] = pose_of(25, 2.0);
  EXPECT_TRUE(odd().empty());
}

TEST_F(OddScansTest, JudgesNeitherPlacesWithFewReturnsNorPartsOfScans) {
  views_[10] = TopView();
  PointCloudFile half;
  for (const Eigen::Vector3d& post_m : posts(1)) {
    const Eigen::Vector3d at_m = pose_of(15).inverse() * post_m;
    if (at_m.y() > 0.0) half.points_m.push_back(at_m);
  }
  views_[15] = {half, SensorProfile()};
  EXPECT_TRUE(odd().empty());
  EXPECT_THAT(odd_scans({views_[0], views_[1]}, {{}, {}}, 1), Each(false));
}

}  // namespace
}  // namespace sightline
