#include "passes/ingest/top_view.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

constexpr int kMiddle = TopView::kCells / 2;
constexpr double kTurnStep_rad = 0.06;

Eigen::Vector2d middle_of(const TopView::Cell& cell) {
  return TopView::kCell_m * Eigen::Vector2d(cell.x - kMiddle + 0.5, cell.y - kMiddle + 0.5);
}

struct CellAt {
  int x = 0;
  int y = 0;
};

CellAt cell_at(const Eigen::Vector2d& point_m) {
  return {static_cast<int>(std::floor(point_m.x() / TopView::kCell_m)) + kMiddle,
          static_cast<int>(std::floor(point_m.y() / TopView::kCell_m)) + kMiddle};
}

std::vector<CellAt> moved(std::span<const TopView::Cell> cells, const PlaneMotion& motion) {
  const auto [sin, cos] = portable_sin_cos(motion.yaw_rad);
  std::vector<CellAt> there;
  there.reserve(cells.size());
  for (const TopView::Cell& cell : cells) {
    const Eigen::Vector2d at_m = middle_of(cell);
    there.push_back(cell_at({cos * at_m.x() - sin * at_m.y() + motion.x_m,
                             sin * at_m.x() + cos * at_m.y() + motion.y_m}));
  }
  return there;
}

// Share of the cells within the square that are cells of the view; 0 where most are outside.
double share_on(const TopView& view, const std::vector<CellAt>& cells, const CellAt& shift) {
  std::size_t within = 0;
  std::size_t on = 0;
  for (const CellAt& cell : cells) {
    const int x = cell.x + shift.x;
    const int y = cell.y + shift.y;
    if (std::min(x, y) < 0 || std::max(x, y) >= TopView::kCells) continue;
    ++within;
    on += view.has(x, y) ? 1 : 0;
  }
  if (2 * within < cells.size()) return 0.0;
  return static_cast<double>(on) / static_cast<double>(within);
}

struct Fit {
  double share = 0.0;
  PlaneMotion motion;
};

// Steps of 1 m and 0.06 rad.
Fit coarse_fit(const TopView& view, std::span<const TopView::Cell> cells,
               const AgreementSearch& search) {
  constexpr int kStep = 2;  // cells
  const TopView wide = view.widened();
  const int turns = static_cast<int>(std::lround(search.turn_rad / kTurnStep_rad));
  const int reach = static_cast<int>(std::lround(search.reach_m / TopView::kCell_m));
  Fit best;
  for (const PlaneMotion& around : search.around) {
    for (int turn = -turns; turn <= turns; ++turn) {
      PlaneMotion motion = around;
      motion.yaw_rad += kTurnStep_rad * turn;
      const std::vector<CellAt> there = moved(cells, motion);
      for (int x = -reach; x <= reach; x += kStep) {
        for (int y = -reach; y <= reach; y += kStep) {
          const double share = share_on(wide, there, {x, y});
          if (share <= best.share) continue;
          best = {share,
                  {motion.x_m + TopView::kCell_m * x, motion.y_m + TopView::kCell_m * y,
                   motion.yaw_rad}};
        }
      }
    }
  }
  return best;
}

double fine_share(const TopView& view, std::span<const TopView::Cell> cells, const Fit& coarse) {
  Fit best{0.0, coarse.motion};
  for (const double step_m : {0.5, 0.25}) {
    const PlaneMotion around = best.motion;
    for (const double turn_rad : {-0.03, 0.0, 0.03}) {
      for (const double x_m : {-step_m, 0.0, step_m}) {
        for (const double y_m : {-step_m, 0.0, step_m}) {
          const PlaneMotion motion{around.x_m + x_m, around.y_m + y_m, around.yaw_rad + turn_rad};
          const double share = share_on(view, moved(cells, motion), {});
          if (share > best.share) best = {share, motion};
        }
      }
    }
  }
  return best.share;
}

}  // namespace

PlaneMotion plane_motion(const Pose& T_before_after) {
  const Eigen::Matrix3d turn = T_before_after.linear();
  return {T_before_after.translation().x(), T_before_after.translation().y(),
          portable_atan2(turn(1, 0), turn(0, 0))};
}

PlaneMotion inverse(const PlaneMotion& motion) {
  const auto [sin, cos] = portable_sin_cos(motion.yaw_rad);
  return {-cos * motion.x_m - sin * motion.y_m, sin * motion.x_m - cos * motion.y_m,
          -motion.yaw_rad};
}

TopView::TopView(const PointCloudFile& cloud, const SensorProfile& sensor) {
  constexpr double kNearest_m = 3.0;
  constexpr double kFarthest_m = 31.0;
  constexpr double kAboveGround_m = 0.5;
  constexpr std::size_t kMostCells = 400;
  const Eigen::Matrix3d level = sensor.T_vehicle_lidar.linear();
  for (const Eigen::Vector3d& point_m : cloud.points_m) {
    const Eigen::Vector3d at_m = level * point_m;
    const double away_m = at_m.head<2>().norm();
    if (!(away_m >= kNearest_m && away_m <= kFarthest_m)) continue;
    if (at_m.z() <= kAboveGround_m - sensor.height_m) continue;
    const CellAt cell = cell_at(at_m.head<2>());
    rows_[static_cast<std::size_t>(cell.y)][static_cast<std::size_t>(cell.x) / 64] |=
        std::uint64_t{1} << (cell.x % 64);
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      if (has(x, y)) cells_.push_back({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y)});
    }
  }
  count_ = static_cast<std::uint32_t>(cells_.size());
  if (cells_.size() <= kMostCells) return;
  for (std::size_t i = 0; i < kMostCells; ++i) {
    cells_[i] = cells_[i * cells_.size() / kMostCells];
  }
  cells_.resize(kMostCells);
  cells_.shrink_to_fit();
}

bool TopView::is_rich() const {
  constexpr std::uint32_t kFewest = 40;
  return count_ >= kFewest;
}

bool TopView::has(int x, int y) const {
  return (rows_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x) / 64] >> (x % 64) & 1) !=
         0;
}

TopView TopView::widened() const {
  const auto beside = [](const Row& row) -> Row {
    return {row[0] | row[0] << 1 | row[0] >> 1 | row[1] << 63,
            row[1] | row[1] << 1 | row[1] >> 1 | row[0] >> 63};
  };
  TopView wide = *this;
  for (std::size_t y = 0; y < rows_.size(); ++y) {
    for (const std::size_t from : {y == 0 ? y : y - 1, y, y + 1 == rows_.size() ? y : y + 1}) {
      const Row row = beside(rows_[from]);
      for (std::size_t i = 0; i < row.size(); ++i) wide.rows_[y][i] |= row[i];
    }
  }
  return wide;
}

std::optional<Agreement> agreement(const TopView& before, const TopView& after,
                                   const AgreementSearch& search) {
  if (!before.is_rich() || !after.is_rich()) return std::nullopt;
  const bool is_back = after.count() > before.count();
  AgreementSearch of_fewer = search;
  if (is_back) {
    for (PlaneMotion& motion : of_fewer.around) motion = inverse(motion);
  }
  const TopView& fewer = is_back ? before : after;
  const TopView& other = is_back ? after : before;
  const Fit coarse = coarse_fit(other, fewer.cells(), of_fewer);
  return Agreement{coarse.share, fine_share(other, fewer.cells(), coarse)};
}

}  // namespace sightline
