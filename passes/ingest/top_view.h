#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/drive/sensor_profile.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/geometry.h"

namespace sightline {

// A motion in the plane: of one scan's sensor in the level axes of another one's.
struct PlaneMotion {
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;
};
PlaneMotion plane_motion(const Pose& T_before_after);
PlaneMotion inverse(const PlaneMotion& motion);

// Where a scan has upright surfaces, seen from above: cells of 0.5 m in a square of 64 m around the
// sensor, in its axes made level. Takes 3 KB.
class TopView {
 public:
  static constexpr int kCells = 128;
  static constexpr double kCell_m = 0.5;

  TopView() = default;
  // Of returns 3 to 31 m away and more than half a metre above the ground, by the profile's height.
  TopView(const PointCloudFile& cloud, const SensorProfile& sensor);

  // In a view with few cells, agreement shows nothing.
  [[nodiscard]] bool is_rich() const;
  [[nodiscard]] bool has(int x, int y) const;
  // The view with the eight cells around each of its cells.
  [[nodiscard]] TopView widened() const;

  struct Cell {
    std::uint8_t x = 0;
    std::uint8_t y = 0;
  };
  // At most 400 of its cells, evenly; those of a widened view are the original's.
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
  [[nodiscard]] std::uint32_t count() const { return count_; }  // of all cells

 private:
  using Row = std::array<std::uint64_t, kCells / 64>;
  std::array<Row, kCells> rows_{};
  std::vector<Cell> cells_;
  std::uint32_t count_ = 0;
};

// Around which motions two views are compared.
struct AgreementSearch {
  std::vector<PlaneMotion> around = {{}};
  double reach_m = 4.0;
  double turn_rad = 0.12;
};

// How well two views agree: shares of the cells of the one with fewer that the other one has too.
struct Agreement {
  double wide = 0.0;  // with widened views
  double fine = 0.0;
};

// The best agreement over motions of `after` in the axes of `before`: in steps of 1 m and 0.06 rad
// with widened views, then around the best one to 0.25 m. Consecutive scans of streets have 0.8 to
// 1 and 0.45 to 0.97, scans of other places up to 0.6 and 0.45. None where a view is not rich.
std::optional<Agreement> agreement(const TopView& before, const TopView& after,
                                   const AgreementSearch& search);

}  // namespace sightline
