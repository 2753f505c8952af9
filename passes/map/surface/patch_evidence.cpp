#include "passes/map/surface/patch_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/parallel.h"

// Rays are followed from cell to cell (Amanatides and Woo, 1987).

namespace sightline {
namespace {

// A ray goes through a patch when it ends behind it by more than noise, relief and unevenness
// within a cell explain.
constexpr double kLeastBehindPlane_m = 0.2;
constexpr double kLeastBeyond_m = 0.4;  // along the ray
// Sine of the angle to the plane (10 degrees). Seen more edge-on, the place where a ray crosses is
// off by more than a square wherever the plane is off by two centimetres.
constexpr double kLeastSlope = 0.17;
// A return farther from a plane, as a share of the patch's half side, is no part of it.
constexpr double kMostOffPlane = 0.3;
// Of a scan.
constexpr std::size_t kReturnsCounted = 32000;
constexpr std::size_t kRaysFollowed = 8000;

// What one scan says of one square.
struct Sight {
  std::uint32_t patch = 0;
  std::uint8_t square = 0;
  bool is_return = true;
};

// Positions floor(n s) with s = t - floor(t - g) no fraction: every ring is met alike. At most
// about `most` of `count`; the same rule as that of measured error (schemas/definitions.md).
std::vector<std::size_t> spread_evenly(std::size_t count, std::size_t most) {
  constexpr double kGolden = 0.6180339887498949;
  const double wanted = static_cast<double>(count) / static_cast<double>(most);
  const double stride = wanted < 1.0 + kGolden ? 1.0 : std::floor(wanted - kGolden) + kGolden;
  std::vector<std::size_t> positions;
  for (double n = 0.0;; n += 1.0) {
    const auto position = static_cast<std::size_t>(n * stride);
    if (position >= count) return positions;
    positions.push_back(position);
  }
}

// From cell to cell along a ray. Each axis has its own sum of steps, from the sensor on, so that
// the cells are the same wherever one begins to look.
class CellWalk {
 public:
  CellWalk(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction, double cell_m)
      : CellWalk(from_m, direction, cell_m, cell_key(from_m, cell_m)) {}

  [[nodiscard]] CellKey cell() const { return {x_.at, y_.at, z_.at}; }
  [[nodiscard]] double entered_m() const { return entered_m_; }

  // Through the nearest face, of equals the first axis'. Without a branch, which would be guessed
  // wrong every other time.
  void go_on() {
    const bool is_x = x_.next_m <= y_.next_m && x_.next_m <= z_.next_m;
    const bool is_y = !is_x && y_.next_m <= z_.next_m;
    const bool is_z = !is_x && !is_y;
    entered_m_ = std::min(x_.next_m, std::min(y_.next_m, z_.next_m));
    x_.go_on_if(is_x);
    y_.go_on_if(is_y);
    z_.go_on_if(is_z);
  }

  // Goes on, at least once, to the first cell that is entered at a distance or beyond.
  void skip_to(double distance_m) {
    x_.skip_to(distance_m);
    y_.skip_to(distance_m);
    z_.skip_to(distance_m);
    go_on();
  }

 private:
  struct Axis {
    double next_m = std::numeric_limits<double>::infinity();  // to the next face
    double step_m = std::numeric_limits<double>::infinity();
    std::int32_t step = 1;
    std::int32_t at = 0;

    Axis(double from_m, double along, double cell_m, std::int32_t begin)
        : step(along > 0.0 ? 1 : -1), at(begin) {
      if (along == 0.0) return;
      step_m = cell_m / std::abs(along);
      next_m = ((at + (along > 0.0 ? 1 : 0)) * cell_m - from_m) / along;
    }
    void go_on_if(bool goes) {
      next_m = goes ? next_m + step_m : next_m;
      at += goes ? step : 0;
    }
    void skip_to(double distance_m) {
      for (; next_m < distance_m; next_m += step_m) at += step;
    }
  };

  CellWalk(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction, double cell_m,
           const CellKey& begin)
      : x_(from_m.x(), direction.x(), cell_m, begin.x),
        y_(from_m.y(), direction.y(), cell_m, begin.y),
        z_(from_m.z(), direction.z(), cell_m, begin.z) {}

  double entered_m_ = 0.0;
  Axis x_, y_, z_;
};

class ScanSights {
 public:
  explicit ScanSights(const PatchGrid& grid) : grid_(grid) {}

  void add_return(const Eigen::Vector3d& point_m) {
    const CellKey cell = cell_key(point_m, grid_.cell_m());
    if (!grid_.is_among(cell)) return;
    for (const std::uint32_t patch : grid_.patches_at(cell)) {
      const PatchPlane& plane = grid_.plane(patch);
      const double off_m = plane.normal.dot(point_m - plane.centre_m);
      if (std::abs(off_m) > kMostOffPlane * plane.half_side_m) continue;
      add(patch, plane.square_of(point_m), true);
    }
  }

  void follow_ray(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m);

  std::vector<Sight> sights;

 private:
  struct Ray {
    Eigen::Vector3d from_m, direction;
    double range_m = 0.0;
  };
  void add(std::uint32_t patch, int square, bool is_return) {
    if (square >= 0) sights.push_back({patch, static_cast<std::uint8_t>(square), is_return});
  }
  void look_at(std::span<const std::uint32_t> patches, const CellKey& cell, const Ray& ray);

  const PatchGrid& grid_;
};

// Each patch counts in the cell in which the ray crosses it.
void ScanSights::look_at(std::span<const std::uint32_t> patches, const CellKey& cell,
                         const Ray& ray) {
  for (const std::uint32_t patch : patches) {
    const PatchPlane& plane = grid_.plane(patch);
    const double slope = plane.normal.dot(ray.direction);
    if (std::abs(slope) < kLeastSlope) continue;
    const double distance_m = plane.normal.dot(plane.centre_m - ray.from_m) / slope;
    const double beyond_m = ray.range_m - distance_m;
    if (!(distance_m > 0.0 && beyond_m > kLeastBeyond_m)) continue;
    if (beyond_m * std::abs(slope) < kLeastBehindPlane_m) continue;
    const Eigen::Vector3d at_m = ray.from_m + distance_m * ray.direction;
    if (cell_key(at_m, grid_.cell_m()) != cell) continue;
    add(patch, plane.square_of(at_m), false);
  }
}

void ScanSights::follow_ray(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  const double range_m = (to_m - from_m).norm();
  const Ray ray{from_m, (to_m - from_m) / range_m, range_m};
  const PatchGrid::Stretch stretch = grid_.stretch_of(from_m, ray.direction);
  const double last_m = std::min({range_m - kLeastBeyond_m, kLongestPass_m, stretch.leave_m});
  if (!(stretch.enter_m < last_m)) return;
  CellWalk walk(from_m, ray.direction, grid_.cell_m());
  if (stretch.enter_m > 0.0) walk.skip_to(stretch.enter_m);
  CellKey key = PatchGrid::block_of(walk.cell());
  PatchBlock block = grid_.block_at(key);
  for (; walk.entered_m() < last_m; walk.go_on()) {
    const CellKey cell = walk.cell();
    if (PatchGrid::block_of(cell) != key) {
      key = PatchGrid::block_of(cell);
      block = grid_.block_at(key);
    }
    look_at(grid_.patches_at(cell, block), cell, ray);
  }
}

ScanSights sights_of(const SeenScan& scan, const PatchGrid& grid) {
  ScanSights seen(grid);
  const std::size_t count = scan.points_m.size();
  for (const std::size_t i : spread_evenly(count, scan.has_origin ? kReturnsCounted : count)) {
    seen.add_return(scan.points_m[i]);
  }
  if (!scan.has_origin) return seen;
  for (const std::size_t i : spread_evenly(count, kRaysFollowed)) {
    seen.follow_ray(scan.origin_m, scan.points_m[i]);
  }
  return seen;
}

}  // namespace

void PatchEvidence::add(std::span<const SeenScan> scans, int threads) {
  std::vector<ScanSights> seen(scans.size(), ScanSights(grid_));
  parallel_for(scans.size(), threads, [&](std::size_t i) {
    ScanSights of_scan = sights_of(scans[i], grid_);
    seen[i].sights = std::move(of_scan.sights);
  });
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (const Sight& sight : seen[i].sights) {
      SquareCounts& counts = counts_[sight.patch];
      std::uint8_t& counter =
          sight.is_return ? counts.returns[sight.square] : counts.passes[sight.square];
      if (counter < 255) ++counter;
    }
  }
}

CountedSights counted_sights(std::uint64_t return_count) {
  return {spread_evenly(return_count, kReturnsCounted).size(),
          spread_evenly(return_count, kRaysFollowed).size()};
}

}  // namespace sightline
