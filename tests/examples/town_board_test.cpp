#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "examples/town/drive/drive.h"

#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

Result<Town> town_with(const std::vector<Board>& boards) {
  TownOptions options;
  options.seed = 4;
  options.length_m = 60.0;
  options.boards = boards;
  return make_town(options);
}

// Beside the driven line 20 m on, turned by 30 degrees from the line's heading.
Board board_of(const Town& town) {
  const LinePoint at = town.plan.line.at(20.0);
  Board board;
  board.pose.position_m = at.position_m + 4.0 * left_of(direction(at.heading_rad));
  board.pose.yaw_rad = at.heading_rad + to_radians(30.0);
  return board;
}

std::vector<LabelledPoint> points_at(const Town& town, std::size_t scan) {
  const DriveSimulator drive =
      value_of(DriveSimulator::make(town, usual_drive(town.options, 0, *town_sensor(64))));
  std::vector<LabelledPoint> points = drive.scan(scan).points;
  for (LabelledPoint& point : points) {
    const Eigen::Vector3d lidar_m = point.position_m.cast<double>();
    point.position_m =
        (drive.T_town_vehicle()[scan] * drive.sensor().T_vehicle_lidar * lidar_m).cast<float>();
  }
  return points;
}

std::size_t count_on(const Board& board, double ground_m,
                     const std::vector<LabelledPoint>& points) {
  const Eigen::Vector2d normal = direction(board.pose.yaw_rad);
  return static_cast<std::size_t>(std::ranges::count_if(points, [&](const LabelledPoint& point) {
    const Eigen::Vector3d p_m = point.position_m.cast<double>();
    const Eigen::Vector2d off_m = p_m.head<2>() - board.pose.position_m;
    const double up_m = p_m.z() - ground_m - board.bottom_m;
    return std::abs(normal.dot(off_m)) < 0.1 &&
           std::abs(left_of(normal).dot(off_m)) < 0.5 * board.width_m + 0.05 && up_m > -0.05 &&
           up_m < board.height_m + 0.05;
  }));
}

TEST(TownBoard, IsSeenWhereItWasPutAndChangesNothingElse) {
  const Town bare = value_of(town_with({}));
  const Board board = board_of(bare);
  const Town town = value_of(town_with({board}));
  const double ground_m = ground_height_m(4, board.pose.position_m);
  const std::size_t before = count_on(board, ground_m, points_at(bare, 12));
  const std::size_t after = count_on(board, ground_m, points_at(town, 12));
  // About 9 m away, 64 beams: some 80 returns on each square metre at least.
  EXPECT_GT(after, before + 100);
  EXPECT_EQ(town.permanent.triangles.size() - bare.permanent.triangles.size(), 12u + 8u * 3u);
  EXPECT_EQ(standing_mesh(town, 1).triangles.size() - standing_mesh(bare, 1).triangles.size(),
            town.permanent.triangles.size() - bare.permanent.triangles.size());
}

TEST(TownBoard, OfNoSizeIsRefused) {
  Board board;
  board.width_m = 0.0;
  EXPECT_EQ(code_of(town_with({board})), ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline::town
