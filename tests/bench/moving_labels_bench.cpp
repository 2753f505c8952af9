// What does remove-moving take out of a real street, whose labels say what moved?
// `moving_labels_bench`: the set pandar128_street of SIGHTLINE_DATA; or any street of one point
// cloud a scan and boxes in a JSON file of the same name. Poses are estimated unless they are
// given.
//
// Returns 4 m and farther from their sensor count; one is gone when its voxel is. An object moved
// when its box, seen 4 times or more, was over 2 m from where it was first.
// - gone: share of the returns in boxes of objects that moved, by range.
// - standing objects: the same of objects that did not.
// - lost: share of the voxels within 40 m that hold a return in no box and not within 0.5 m of a
//   moving box, which no moving box ever swept, that are gone. Ground: up to 0.3 m above it. Above
//   3 m: seen by two scans or more.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <deque>
#include <map>
#include <set>

#include "formats/foreign/recording/open_recording.h"
#include "formats/grid/cell_index.h"
#include "passes/ingest/ingest.h"
#include "passes/map/remove_moving.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "passes/trajectory/undistort_scans.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/moving_labels.h"
#include "tests/support/real_data.h"

namespace sightline {
namespace {

constexpr double kNearest_m = 4.0;  // the vehicle's own returns lie nearer
constexpr double kLostWithin_m = 40.0;
constexpr double kBesideBox_m = 0.5;
constexpr double kGround_m = 0.3;
constexpr double kHigh_m = 3.0;
constexpr double kColumn_m = 1.0;
// The ground of a street rises at most so much from one column to the next; more is a wall or what
// stands on it.
constexpr double kGroundStep_m = 0.25;

struct Street {
  Drive raw;    // as recorded: labels are of it
  Drive drive;  // undistorted
  Trajectory trajectory;
  SurfacePoints points;
  double removal_cpu_s = 0.0;
  std::vector<std::vector<LabelBox>> boxes;  // of each scan of `points`
  std::vector<Pose> T_map_lidar;
  std::unordered_map<std::string, LabelMotion> motions;
};

struct LabelledVoxel {
  std::uint32_t clean_scans = 0;  // with a return in no box, away from moving ones, within 40 m
  std::uint32_t last_scan = 0;
  bool is_swept = false;
  bool is_gone = false;
};
using LabelledVoxels = CellTable<LabelledVoxel>;

void print(const char* what, const Share& share) {
  std::printf("%-46s %7.3f %% of %9lu\n", what, share.percent(0.0),
              static_cast<unsigned long>(share.all));
}

struct Figures {
  Share gone[3];  // 4-20, 20-40, 40-60 m
  Share standing_objects;
  Share lost, lost_ground, lost_low, lost_high, lost_high_seen_again;
};

Result<Street> compile(PassContext& ctx, const RecordingOptions& recorded,
                       const RemoveMovingOptions& removal) {
  SIGHTLINE_ASSIGN(const Recording recording, open_recording(recorded, ctx.threads));
  Street street;
  SIGHTLINE_ASSIGN(street.raw, ingest(ctx, {}, recording));
  EstimateTrajectoryOptions estimate;
  estimate.bad_poses = BadPoses::kIgnore;
  SIGHTLINE_ASSIGN(street.trajectory, estimate_trajectory(ctx, estimate, street.raw));
  SIGHTLINE_ASSIGN(street.drive, undistort_scans(ctx, {}, street.raw, street.trajectory));
  const double begin_s = cpu_s();
  SIGHTLINE_ASSIGN(street.points, remove_moving(ctx, removal, street.drive, street.trajectory));
  street.removal_cpu_s = cpu_s() - begin_s;
  return street;
}

Result<void> read_labels(const std::filesystem::path& folder, Street& street) {
  for (const PlacedScan& placed : street.points.scans) {
    const std::filesystem::path source = street.drive.scans[placed.index].source;
    SIGHTLINE_ASSIGN(std::vector<LabelBox> boxes,
                     read_label_boxes(folder / source.stem().concat(".json")));
    street.boxes.push_back(std::move(boxes));
    street.T_map_lidar.push_back(placed.T_map_lidar);
  }
  street.motions = motions_of(street.boxes, street.T_map_lidar);
  return {};
}

struct Where {
  bool is_in_box = false;
  bool is_in_moved = false;
  bool is_in_stood = false;
  bool is_beside_moved = false;
};

Where where(const Street& street, std::size_t k, const Eigen::Vector3d& point_lidar_m) {
  Where found;
  for (const LabelBox& box : street.boxes[k]) {
    const double reach_m = box.half_m.norm() + kBesideBox_m;
    if ((box.T_lidar_box.translation() - point_lidar_m).squaredNorm() > reach_m * reach_m) continue;
    const LabelMotion motion = street.motions.at(box.object);
    const bool is_inside = box.contains(point_lidar_m, 0.0);
    found.is_in_box |= is_inside;
    found.is_in_moved |= is_inside && motion == LabelMotion::kMoved;
    found.is_in_stood |= is_inside && motion == LabelMotion::kStood;
    found.is_beside_moved |=
        motion == LabelMotion::kMoved && box.contains(point_lidar_m, kBesideBox_m);
  }
  return found;
}

void count_object(const Where& at, double range_m, bool is_gone, Figures& figures) {
  if (at.is_in_moved && range_m < 60.0) {
    figures.gone[range_m < 20.0 ? 0 : range_m < 40.0 ? 1 : 2].count(is_gone);
  } else if (at.is_in_stood && range_m < 60.0) {
    figures.standing_objects.count(is_gone);
  }
}

Result<void> count_returns(const Street& street, LabelledVoxels& voxels, Figures& figures) {
  std::set<CellKey> swept;  // by returns: boxes lie where the raw scan has them
  for (std::uint32_t k = 0; k < street.points.scans.size(); ++k) {
    const PlacedScan& placed = street.points.scans[k];
    SIGHTLINE_ASSIGN(const Scan raw, street.raw.store->read(placed.index));
    SIGHTLINE_ASSIGN(const Scan scan, street.points.store->read(placed.index));
    for (std::size_t i = 0; i < scan.points_m.size(); ++i) {
      const Eigen::Vector3d& point_lidar_m = raw.points_m[i];
      const double range_m = point_lidar_m.norm();
      if (range_m < kNearest_m || !is_within_range(placed, scan.points_m[i])) continue;
      const CellKey key = cell_key(placed.T_map_lidar * scan.points_m[i], street.points.voxel_m);
      const Where at = where(street, k, point_lidar_m);
      const LabelledVoxel* seen = voxels.find(key);
      count_object(at, range_m, seen != nullptr && seen->is_gone, figures);
      if (at.is_in_moved) swept.insert(key);
      if (at.is_in_box || at.is_beside_moved || range_m > kLostWithin_m) continue;
      const std::uint32_t v = voxels.insert(key).number;
      LabelledVoxel& voxel = voxels.values()[v];
      if (voxel.clean_scans == 0 || voxel.last_scan != k) ++voxel.clean_scans;
      voxel.last_scan = k;
    }
  }
  for (const CellKey& key : swept) {
    if (LabelledVoxel* voxel = voxels.find(key)) voxel->is_swept = true;
  }
  return {};
}

void sweep(const Street& street, LabelledVoxels& voxels) {
  const double voxel_m = street.points.voxel_m;
  for (std::size_t k = 0; k < street.boxes.size(); ++k) {
    for (const LabelBox& box : street.boxes[k]) {
      if (street.motions.at(box.object) != LabelMotion::kMoved) continue;
      const Pose T_lidar_map = street.T_map_lidar[k].inverse(Eigen::Isometry);
      const Eigen::Vector3d middle_m = street.T_map_lidar[k] * box.T_lidar_box.translation();
      const Eigen::Vector3d reach_m = Eigen::Vector3d::Constant(box.half_m.norm());
      const CellKey low = cell_key(middle_m - reach_m, voxel_m);
      const CellKey high = cell_key(middle_m + reach_m, voxel_m);
      for (CellKey key = low; key.x <= high.x; ++key.x) {
        for (key.y = low.y; key.y <= high.y; ++key.y) {
          for (key.z = low.z; key.z <= high.z; ++key.z) {
            LabelledVoxel* voxel = voxels.find(key);
            if (voxel == nullptr || voxel->is_swept) continue;
            voxel->is_swept = box.contains(T_lidar_map * cell_centre_m(key, voxel_m), 0.0);
          }
        }
      }
    }
  }
}

// Height of the ground in columns of 1 m: from the route outwards, a column whose lowest voxel
// continues the one before is ground there, any other takes over the height before it.
class Ground {
 public:
  Ground(const Street& street, const LabelledVoxels& voxels) {
    std::map<TileKey, double> lowest_m;
    for (std::size_t v = 0; v < voxels.size(); ++v) {
      if (voxels.values()[v].clean_scans == 0) continue;
      const Eigen::Vector3d at_m = cell_centre_m(voxels.keys()[v], street.points.voxel_m);
      const auto [entry, is_new] = lowest_m.try_emplace(tile_key(at_m, kColumn_m), at_m.z());
      if (!is_new) entry->second = std::min(entry->second, at_m.z());
    }
    std::deque<TileKey> next;
    for (const Pose& T_map_lidar : street.T_map_lidar) {
      const Eigen::Vector3d at_m = T_map_lidar.translation();
      const double height_m = at_m.z() - street.drive.sensor.height_m;
      if (height_m_.try_emplace(tile_key(at_m, kColumn_m), height_m).second) {
        next.push_back(tile_key(at_m, kColumn_m));
      }
    }
    for (; !next.empty(); next.pop_front()) spread(next.front(), lowest_m, next);
  }

  [[nodiscard]] double above_m(const Eigen::Vector3d& point_m) const {
    const auto entry = height_m_.find(tile_key(point_m, kColumn_m));
    return entry == height_m_.end() ? 0.0 : point_m.z() - entry->second;
  }

  // Not only taken over from its neighbours.
  [[nodiscard]] bool is_seen_below(const Eigen::Vector3d& point_m) const {
    return seen_.contains(tile_key(point_m, kColumn_m));
  }

 private:
  void spread(const TileKey& from, const std::map<TileKey, double>& lowest_m,
              std::deque<TileKey>& next) {
    constexpr int kFarthest = 80;  // columns from the origin of a short street
    const double before_m = height_m_.at(from);
    for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const TileKey to{from.x + x, from.y + y};
      if (height_m_.contains(to) || std::abs(to.x) > 3 * kFarthest || std::abs(to.y) > kFarthest) {
        continue;
      }
      const auto lowest = lowest_m.find(to);
      const bool goes_on =
          lowest != lowest_m.end() && std::abs(lowest->second - before_m) <= kGroundStep_m;
      height_m_[to] = goes_on ? lowest->second : before_m;
      if (goes_on) seen_.insert(to);
      next.push_back(to);
    }
  }

  std::map<TileKey, double> height_m_;
  std::set<TileKey> seen_;
};

void count_voxels(const Street& street, const LabelledVoxels& voxels, const char* csv,
                  Figures& figures) {
  const Ground ground(street, voxels);
  std::FILE* out = csv == nullptr ? nullptr : std::fopen(csv, "w");
  for (std::size_t v = 0; v < voxels.size(); ++v) {
    const LabelledVoxel& voxel = voxels.values()[v];
    if (voxel.clean_scans == 0 || voxel.is_swept) continue;
    const Eigen::Vector3d at_m = cell_centre_m(voxels.keys()[v], street.points.voxel_m);
    const double above_m = ground.above_m(at_m);
    figures.lost.count(voxel.is_gone);
    if (above_m <= kGround_m) {
      figures.lost_ground.count(voxel.is_gone);
    } else if (above_m <= kHigh_m) {
      figures.lost_low.count(voxel.is_gone);
    } else {
      figures.lost_high.count(voxel.is_gone);
      if (voxel.clean_scans >= 2 && ground.is_seen_below(at_m))
        figures.lost_high_seen_again.count(voxel.is_gone);
    }
    if (out != nullptr) {
      std::fprintf(out, "%.1f %.1f %.1f %.2f %u %d\n", at_m.x(), at_m.y(), at_m.z(), above_m,
                   voxel.clean_scans, voxel.is_gone ? 1 : 0);
    }
  }
  if (out != nullptr) std::fclose(out);
}

int report(const Error& error) {
  std::fprintf(stderr, "%s\n", to_string(error).c_str());
  return 1;
}

int run(const RecordingOptions& recorded, const std::string& labels, bool is_even,
        const std::string& csv) {
  PassContext ctx;
  ctx.threads = 2;
  RemoveMovingOptions removal;
  removal.scans = is_even ? ScanSelection::kEven : ScanSelection::kAll;
  Result<Street> street = compile(ctx, recorded, removal);
  if (!street) return report(street.error());
  const Result<void> read = read_labels(labels, *street);
  if (!read) return report(read.error());
  LabelledVoxels voxels;
  for (const CellKey& key : street->points.moved_voxels) voxels.insert(key, {0, 0, false, true});
  Figures figures;
  const Result<void> counted = count_returns(*street, voxels, figures);
  if (!counted) return report(counted.error());
  sweep(*street, voxels);
  count_voxels(*street, voxels, csv.empty() ? nullptr : csv.c_str(), figures);
  std::printf("%zu scans, remove-moving took %.1f CPU s\n", street->points.scans.size(),
              street->removal_cpu_s);
  print("gone, returns at 4 to 20 m", figures.gone[0]);
  print("gone, returns at 20 to 40 m", figures.gone[1]);
  print("gone, returns at 40 to 60 m", figures.gone[2]);
  print("gone of objects that stood, returns", figures.standing_objects);
  print("lost, voxels", figures.lost);
  print("lost, of the ground", figures.lost_ground);
  print("lost, 0.3 to 3 m above it", figures.lost_low);
  print("lost, above 3 m", figures.lost_high);
  print("lost, above 3 m, seen again, over seen ground", figures.lost_high_seen_again);
  return 0;
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  const sightline::RealData data = sightline::real_data("pandar128_street");
  sightline::RecordingOptions recorded;
  recorded.poses_of = sightline::PosesOf::kSensor;
  recorded.sensor = "generic-128";
  std::string labels;
  std::string csv;
  bool is_even = false;
  CLI::App app("What remove-moving takes out of a street whose labels say what moved.");
  app.add_option("--scans", recorded.scans, "folder of scans; without: pandar128_street");
  app.add_option("--labels", labels, "folder of their boxes");
  app.add_option("--poses", recorded.poses, "given poses of the sensor; without: estimated");
  app.add_option("--sensor", recorded.sensor);
  app.add_option("--voxels", csv, "writes x y z height clean-scans gone of each voxel that counts");
  app.add_flag("--even", is_even, "map the even scans alone");
  CLI11_PARSE(app, argc, argv);
  if (recorded.scans.empty()) {
    if (!data.missing.empty()) {
      std::fprintf(stderr, "skipped: %s\n", data.missing.c_str());
      return 0;
    }
    recorded.scans = (data.folder / "pandar128_street" / "lidar").string();
    labels = (data.folder / "pandar128_street" / "label").string();
  }
  return sightline::run(recorded, labels, is_even, csv);
}
