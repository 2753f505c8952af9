#include "passes/trajectory/pieces/join_pieces.h"

#include <gtest/gtest.h>

#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

std::vector<Pose> along(double from_m, double to_m) {
  std::vector<Pose> poses;
  const double step_m = from_m < to_m ? 1.0 : -1.0;
  for (double x_m = from_m; step_m * x_m <= step_m * to_m; x_m += step_m) {
    poses.push_back(pose_at(x_m, 0.0, from_m < to_m ? 0.0 : 3.1));
  }
  return poses;
}

// Pieces along one street, each but the first in a frame of its own.
struct Street {
  TestDrive test;
  Odometry odometry;

  explicit Street(const std::vector<std::vector<Pose>>& pieces,
                  const BoxWorld& world = random_street(4)) {
    std::vector<Pose> poses;
    for (std::uint32_t piece = 0; piece < pieces.size(); ++piece) {
      const auto first = static_cast<std::uint32_t>(poses.size());
      if (piece > 0) odometry.piece_starts.push_back({first, true});
      poses.insert(poses.end(), pieces[piece].begin(), pieces[piece].end());
      odometry.piece.resize(poses.size(), piece);
    }
    test = drive_through(world, poses, 0.5);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double piece = odometry.piece[i];
      const Pose T_own_map = pose_at(300.0 * piece, -40.0 * piece, 0.7 * piece);
      odometry.T_map_lidar.push_back(T_own_map * poses[i] * test.drive.sensor.T_vehicle_lidar);
      odometry.driven_m.push_back(static_cast<double>(i));
    }
  }

  [[nodiscard]] double largest_error_m() const {
    double largest_m = 0.0;
    for (std::size_t i = 0; i < odometry.piece.size(); ++i) {
      const Pose T_true = test.truth.poses[i].T_map_vehicle * test.drive.sensor.T_vehicle_lidar;
      const Eigen::Vector3d off_m = odometry.T_map_lidar[i].translation() - T_true.translation();
      largest_m = std::max(largest_m, off_m.norm());
    }
    return largest_m;
  }
};

// Two pieces that do not meet, and a third that passes both: whichever it is found in first, all
// lie in the frame of the first piece, which is that of the map.
TEST(JoinPieces, MovesAllToTheFrameOfTheFirst) {
  for (const auto& [from_m, to_m] : {std::pair(-18.0, 75.0), std::pair(75.0, -18.0)}) {
    Street street({along(-20.0, 8.0), along(48.0, 76.0), along(from_m, to_m)});
    const std::vector<std::optional<Pose>> none(street.odometry.piece.size());
    const JoinedPieces joined =
        value_of(join_pieces(TestContext(2), street.test.drive, none, street.odometry));
    EXPECT_EQ(joined.piece, std::vector<std::uint32_t>(street.odometry.piece.size(), 0));
    EXPECT_TRUE(joined.starts.empty());
    EXPECT_LT(street.largest_error_m(), 0.5);
    EXPECT_TRUE(street.odometry.T_map_lidar[0].isApprox(
        street.test.truth.poses[0].T_map_vehicle * street.test.drive.sensor.T_vehicle_lidar, 0.0));
  }
}

// A first piece on two storeys, and a second one on the upper storey.
Street on_storeys(const BoxWorld& upper) {
  std::vector<Pose> first = along(-20.0, 20.0);
  std::vector<Pose> second;
  for (Pose pose : along(20.0, -20.0)) {
    pose.translation().z() = kTestStorey_m;
    first.push_back(pose);
  }
  for (Pose pose : along(-15.0, 15.0)) {
    pose.translation().z() = kTestStorey_m;
    second.push_back(pose);
  }
  return Street({first, second}, storeys_of({random_street(4), upper}));
}

TEST(JoinPieces, FindsTheStoreyOfAPieceAndLeavesItApartWhereTwoLookAlike) {
  for (const std::uint64_t upper : {9U, 4U}) {
    Street street = on_storeys(random_street(upper));
    const std::vector<std::optional<Pose>> none(street.odometry.piece.size());
    const JoinedPieces joined =
        value_of(join_pieces(TestContext(2), street.test.drive, none, street.odometry));
    EXPECT_EQ(joined.piece.back(), upper == 4 ? 1U : 0U);
    if (upper != 4) {
      EXPECT_LT(street.largest_error_m(), 0.5);
    }
  }
}

}  // namespace
}  // namespace sightline
