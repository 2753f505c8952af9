#include "passes/map/tile_carver.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "passes/map/asked_voxels.h"
#include "passes/map/drive_evidence.h"
#include "passes/map/scan_rays.h"
#include "passes/map/seen_voxels.h"

// A voxel that some scans hit and many others look through held something that moved. A tile reads
// its scans twice: for its voxels, then to look through them.

namespace sightline {
namespace {

// So that what lies at exactly a range is decided by its distance, not by rounding of a box.
constexpr double kSlack_m = 0.01;
using Box2 = Eigen::AlignedBox2d;

Box2 with_halo(const Box2& box, double halo_m) {
  return {box.min() - Eigen::Vector2d::Constant(halo_m),
          box.max() + Eigen::Vector2d::Constant(halo_m)};
}

Eigen::Vector2d centre_m(const CellKey& key, double voxel_m) {
  return cell_centre_m(key, voxel_m).head<2>();
}

// Where the tile's verdicts depend on what lies there.
Box2 reach_of_tile(const CarveOptions& options, const TileKey& tile) {
  return with_halo(box_of(tile, options.tile_m), reach_of_judgement_m(options.voxel_m));
}

class TileCarver {
 public:
  TileCarver(const CarveOptions& options, const ScanStore& store, std::span<const PlacedScan> scans,
             const TileKey& tile)
      : options_(options),
        store_(store),
        scans_(scans),
        tile_(box_of(tile, options.tile_m)),
        reach_(reach_of_tile(options, tile)),
        origins_(origins_of(scans)),
        hit_voxels_(scans.size()) {
    bool has_several = false;
    for (const PlacedScan& scan : scans) {
      last_part_ = std::max(last_part_, scan.part);
      has_several = has_several || scan.part != scans.front().part;
    }
    if (has_several) of_drives_.emplace(last_part_ + 1);
  }

  Result<void> look() {
    SIGHTLINE_TRY(collect());
    mark_ground(seen_);
    return carve();
  }

  [[nodiscard]] const SeenVoxels& seen() const { return seen_; }

  [[nodiscard]] TileFindings findings() const {
    TileFindings found;
    found.of_scans = of_scans_;
    const std::vector<std::uint8_t> moved = judge(seen_);
    for (std::size_t v = 0; v < moved.size(); ++v) {
      const CellKey key = seen_.keys()[v];
      if (moved[v] == 0 || !is_inside(centre_m(key, options_.voxel_m))) continue;
      found.moved_voxels.push_back(key);
      found.moving_count += seen_.values()[v].point_count;
    }
    std::ranges::sort(found.moved_voxels);
    return found;
  }

  [[nodiscard]] std::vector<ComparedSquare> compared(std::uint32_t first_new,
                                                     double square_m) const {
    if (!of_drives_) return {};
    std::map<TileKey, ComparedSquare> squares;
    const std::vector<DriveEvidence::Comparison> of_voxels = of_drives_->compare(seen_, first_new);
    for (std::size_t v = 0; v < of_voxels.size(); ++v) {
      if (of_voxels[v] == DriveEvidence::Comparison::kNothing) continue;
      const Eigen::Vector3d at_m = cell_centre_m(seen_.keys()[v], options_.voxel_m);
      if (!is_inside(at_m.head<2>())) continue;
      ComparedSquare& square = squares[tile_key(at_m, square_m)];
      const bool is_confirmed = of_voxels[v] == DriveEvidence::Comparison::kConfirmed;
      ++(is_confirmed ? square.confirmed : square.changed);
    }
    std::vector<ComparedSquare> found;
    for (auto& [key, square] : squares) {
      square.square = key;
      found.push_back(square);
    }
    return found;
  }

 private:
  Result<void> collect() {
    const Box2 near = with_halo(reach_, options_.voxel_m);
    for (std::uint32_t k = 0; k < scans_.size(); ++k) {
      const Eigen::Vector2d origin_m = scans_[k].T_map_lidar.translation().head<2>();
      if (reach_.exteriorDistance(origin_m) > scans_[k].max_range_m) continue;
      SIGHTLINE_ASSIGN(const Scan scan, store_.read(scans_[k].index));
      returns_m_.clear();
      std::uint64_t in_range = 0;
      for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
        if (!is_within_range(scans_[k], point_lidar_m)) continue;
        ++in_range;
        const Eigen::Vector3d return_m = scans_[k].T_map_lidar * point_lidar_m;
        if (near.contains(return_m.head<2>())) returns_m_.push_back(return_m);
      }
      if (is_inside(origin_m)) {
        of_scans_.in_range += in_range;
        of_scans_.out_of_range += scan.points_m.size() - in_range;
      }
      add_returns(k);
    }
    return {};
  }

  // Those of scan k. Voxels are asked for ahead: they lie anywhere in memory.
  void add_returns(std::uint32_t k) {
    constexpr std::size_t kAhead = 12;
    keys_.resize(returns_m_.size());
    cell_keys(returns_m_, options_.voxel_m, keys_);
    runs_.resize(keys_.size());
    runs_.resize(find_runs(keys_, runs_));
    // By the voxel's centre, so that a voxel belongs to one tile as a whole.
    std::erase_if(runs_, [&](const CellRun& run) {
      return !reach_.contains(centre_m(run.key, options_.voxel_m));
    });
    numbers_.resize(runs_.size());
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (i + kAhead < runs_.size()) seen_.prefetch(runs_[i + kAhead].key);
      numbers_[i] = seen_.insert(runs_[i].key).number;
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (i + kAhead < runs_.size()) __builtin_prefetch(&seen_.values()[numbers_[i + kAhead]], 1);
      add_run(numbers_[i], std::span(returns_m_).subspan(runs_[i].begin, runs_[i].count), k);
    }
  }

  void add_run(std::uint32_t v, std::span<const Eigen::Vector3d> returns_m, std::uint32_t k) {
    SeenVoxel& voxel = seen_.values()[v];
    for (const Eigen::Vector3d& return_m : returns_m) voxel.sum_m += return_m;
    voxel.point_count += static_cast<std::uint32_t>(returns_m.size());
    if (voxel.hits > 0 && voxel.last_scan == k) return;
    ++voxel.hits;
    if (of_drives_) of_drives_->add_hit(v, scans_[k].part);
    voxel.last_scan = k;
    hit_voxels_[k].push_back(v);
  }

  Result<void> carve() {
    AskedVoxels asked({options_.voxel_m, options_.carve_range_m}, seen_,
                      of_drives_ ? &*of_drives_ : nullptr,
                      [&](const Box2& box) { return scans_near(box); });
    ScanRays rays;
    for (std::uint32_t k = 0; k < scans_.size(); ++k) {
      const PlacedScan& placed = scans_[k];
      if (reach_.exteriorDistance(placed.T_map_lidar.translation().head<2>()) >
          options_.carve_range_m) {
        continue;
      }
      SIGHTLINE_ASSIGN(const Scan scan, store_.read(placed.index));
      find_rays(placed, scan);
      rays.take(returns_m_);
      asked.look({k, placed.part, placed.T_map_lidar, rays, hit_voxels_[k]});
    }
    asked.conclude();
    if (of_drives_) of_drives_->conclude(seen_);
    return {};
  }

  // Fills returns_m_, in the sensor's frame, with those whose rays may come near a voxel here: not
  // those of which both ends lie beyond the same edge.
  void find_rays(const PlacedScan& placed, const Scan& scan) {
    const Box2 near =
        with_halo(reach_, options_.voxel_m + AskedVoxels::touch_m(options_.voxel_m) + kSlack_m);
    const Eigen::Vector2d origin_m = placed.T_map_lidar.translation().head<2>();
    const Eigen::Matrix<double, 2, 3> turn = placed.T_map_lidar.linear().topRows<2>();
    const auto passes_by = [&](double a_m, double b_m, int axis) {
      return (a_m < near.min()[axis] && b_m < near.min()[axis]) ||
             (a_m > near.max()[axis] && b_m > near.max()[axis]);
    };
    returns_m_.clear();
    for (const Eigen::Vector3d& point_lidar_m : scan.points_m) {
      if (!is_within_range(placed, point_lidar_m)) continue;
      const Eigen::Vector2d end_m = turn * point_lidar_m + origin_m;
      if (passes_by(origin_m.x(), end_m.x(), 0) || passes_by(origin_m.y(), end_m.y(), 1)) continue;
      returns_m_.push_back(point_lidar_m);
    }
  }

  // How many scans may look into a place, of each part of the drive.
  std::vector<std::size_t> scans_near(const Box2& box) const {
    std::vector<std::size_t> counts(last_part_ + 1, 0);
    origins_.visit_over(with_halo(box, options_.carve_range_m + kSlack_m), [&](std::size_t k) {
      const Eigen::Vector2d origin_m = scans_[k].T_map_lidar.translation().head<2>();
      if (box.exteriorDistance(origin_m) <= options_.carve_range_m) ++counts[scans_[k].part];
    });
    return counts;
  }

  bool is_inside(const Eigen::Vector2d& at_m) const {
    return (at_m.array() >= tile_.min().array()).all() &&
           (at_m.array() < tile_.max().array()).all();
  }

  const CarveOptions& options_;
  const ScanStore& store_;
  std::span<const PlacedScan> scans_;
  Box2 tile_;
  Box2 reach_;         // with the surroundings that decide about its voxels
  PointGrid origins_;  // of the scans
  std::uint32_t last_part_ = 0;
  std::optional<DriveEvidence> of_drives_;  // where scans of several drives are here
  ReturnCounts of_scans_;
  SeenVoxels seen_;
  std::vector<std::vector<std::uint32_t>> hit_voxels_;  // of each scan, each once
  // Of one scan; kept for their memory.
  std::vector<Eigen::Vector3d> returns_m_;
  std::vector<CellKey> keys_;
  std::vector<CellRun> runs_;
  std::vector<std::uint32_t> numbers_;
};

}  // namespace

Result<TileFindings> find_moving_in_tile(const CarveOptions& options, const ScanStore& store,
                                         std::span<const PlacedScan> scans, const TileKey& tile) {
  TileCarver carver(options, store, scans, tile);
  SIGHTLINE_TRY(carver.look());
  return carver.findings();
}

Result<std::vector<ComparedSquare>> compare_in_tile(const CarveOptions& options,
                                                    const ScanStore& store,
                                                    std::span<const PlacedScan> scans,
                                                    const TileKey& tile, std::uint32_t first_new,
                                                    double square_m) {
  TileCarver carver(options, store, scans, tile);
  SIGHTLINE_TRY(carver.look());
  return carver.compared(first_new, square_m);
}

Result<SeenVoxels> look_at_tile(const CarveOptions& options, const ScanStore& store,
                                std::span<const PlacedScan> scans, const TileKey& tile) {
  TileCarver carver(options, store, scans, tile);
  SIGHTLINE_TRY(carver.look());
  return carver.seen();
}

PointGrid origins_of(std::span<const PlacedScan> scans) {
  constexpr double kCell_m = 16.0;  // sensors see several times as far
  std::vector<Eigen::Vector3d> origins_m;
  for (const PlacedScan& scan : scans) origins_m.push_back(scan.T_map_lidar.translation());
  return PointGrid(origins_m, kCell_m);
}

std::vector<PlacedScan> scans_of_tile(const CarveOptions& options,
                                      std::span<const PlacedScan> scans, const PointGrid& origins,
                                      const TileKey& tile) {
  double range_m = options.carve_range_m;
  for (const PlacedScan& scan : scans) range_m = std::max(range_m, scan.max_range_m);
  std::vector<std::size_t> near;
  origins.visit_over(with_halo(reach_of_tile(options, tile), range_m + kSlack_m),
                     [&](std::size_t k) { near.push_back(k); });
  std::ranges::sort(near);
  std::vector<PlacedScan> found;
  for (const std::size_t k : near) found.push_back(scans[k]);
  return found;
}

std::vector<TileKey> tiles_to_look_at(const CarveOptions& options,
                                      std::span<const PlacedScan> scans) {
  const double range_m = options.carve_range_m + reach_of_judgement_m(options.voxel_m);
  std::set<TileKey> tiles;
  for (const PlacedScan& scan : scans) {
    const Eigen::Vector2d origin_m = scan.T_map_lidar.translation().head<2>();
    const auto index_of = [&](double x_m) { return floor_to_int(x_m / options.tile_m); };
    for (int x = index_of(origin_m.x() - range_m); x <= index_of(origin_m.x() + range_m); ++x) {
      for (int y = index_of(origin_m.y() - range_m); y <= index_of(origin_m.y() + range_m); ++y) {
        if (box_of({x, y}, options.tile_m).exteriorDistance(origin_m) <= range_m) {
          tiles.insert({x, y});
        }
      }
    }
  }
  return {tiles.begin(), tiles.end()};
}

}  // namespace sightline
