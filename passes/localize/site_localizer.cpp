#include "passes/localize/site_localizer.h"

#include <bit>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

class OwnSiteLocalizer : public SiteLocalizer {
 public:
  explicit OwnSiteLocalizer(const SiteLocalizerInputs& inputs)
      : inputs_(inputs), cutter_(inputs.choice.leaf_m) {}
  void go_to(const Eigen::Vector3d& /*p_map_m*/, std::uint64_t /*seed*/) override {}
  void take(const Scan& scan, const Look& look) override {
    scan_ = &scan;
    look_ = look;
    if (!takes_every_return(look)) return;
    const ScanCut cut{look.range_m, inputs_.choice.leaf_m};
    if (inputs_.choice.thins_near) {
      cut_ = make_scan_for_match(inputs_.own, near_cutter_, scan, inputs_.sensor, cut);
    } else {
      cutter_.cut(inputs_.own, scan, inputs_.sensor, look, Pose::Identity(), cut_);
    }
  }
  MatchResult match(const Pose& T_map_start) override {
    if (takes_every_return(look_)) return localize(inputs_.own, cut_, T_map_start);
    cutter_.cut(inputs_.of_samples, *scan_, inputs_.sensor, look_, T_map_start, cut_);
    const MatchOptions options{.stop_step_m = kSampleStop_m};
    return look_.mode == LookMode::kSettle
               ? settle(inputs_.of_samples, cut_, T_map_start, options)
               : localize(inputs_.of_samples, cut_, T_map_start, options);
  }
  [[nodiscard]] std::size_t point_count() const override { return cut_.points_m.size(); }

 private:
  SiteLocalizerInputs inputs_;
  ScanCutter near_cutter_;
  LookCutter cutter_;
  ScanForMatch cut_;
  const Scan* scan_ = nullptr;
  Look look_;
};

// A scan as Autoware's filters leave it for its NDT: a box around the vehicle, one centroid in a
// voxel, then so many of them at random. The range is ours: what lies beyond it was not looked at.
constexpr double kBox_m = 60.0;  // to each side; and from so far below to so far above
constexpr double kBoxBelow_m = 30.0;
constexpr double kBoxAbove_m = 50.0;
constexpr double kVoxel_m = 3.0;
constexpr std::size_t kMostPoints = 1500;

bool is_in_box(const Eigen::Vector3d& p_vehicle_m) {
  return std::abs(p_vehicle_m.x()) <= kBox_m && std::abs(p_vehicle_m.y()) <= kBox_m &&
         p_vehicle_m.z() >= -kBoxBelow_m && p_vehicle_m.z() <= kBoxAbove_m;
}

// `count` of the points, each as likely as any other: the first steps of a shuffle.
void keep_random(std::size_t count, Random random, std::vector<Eigen::Vector3d>& points_m) {
  if (points_m.size() <= count) return;
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(points_m[i], points_m[i + random.below(points_m.size() - i)]);
  }
  points_m.resize(count);
}

class PclSiteLocalizer : public SiteLocalizer {
 public:
  explicit PclSiteLocalizer(const SiteLocalizerInputs& inputs) : inputs_(inputs) {}
  void go_to(const Eigen::Vector3d& p_map_m, std::uint64_t seed) override {
    ndt_.emplace(inputs_.map, p_map_m);
    seed_ = seed;
  }
  void take(const Scan& scan, const Look& look) override {
    const double range_m = look.range_m;
    std::vector<Eigen::Vector3d> points_m;
    for (const Eigen::Vector3d& p_sensor_m : scan.points_m) {
      if (p_sensor_m.squaredNorm() > range_m * range_m) continue;
      const Eigen::Vector3d p_vehicle_m = inputs_.sensor.T_vehicle_lidar * p_sensor_m;
      if (is_in_box(p_vehicle_m)) points_m.push_back(p_vehicle_m);
    }
    points_m = voxel_subsample(points_m, kVoxel_m);
    keep_random(kMostPoints, Random(mix(seed_, std::bit_cast<std::uint64_t>(range_m))), points_m);
    ndt_->set_scan(points_m);
    point_count_ = points_m.size();
  }
  MatchResult match(const Pose& T_map_start) override {
    const PclMatch found = ndt_->match(T_map_start);
    MatchResult result;
    result.T_map_sensor = found.T_map_scan;
    result.iterations = found.iterations;
    result.work = static_cast<std::uint64_t>(found.iterations) * point_count_;
    return result;
  }
  [[nodiscard]] std::size_t point_count() const override { return point_count_; }

 private:
  SiteLocalizerInputs inputs_;
  std::optional<PclNdt> ndt_;
  std::uint64_t seed_ = 0;
  std::size_t point_count_ = 0;
};

LocalizerProfile pcl_profile(const NdtMap& map) {
  return {"pcl-ndt",
          kLocalizersVersion,
          {{"box_m", format_double(kBox_m)},
           {"epsilon_m", format_double(PclNdt::kEpsilon_m)},
           {"iterations", std::to_string(PclNdt::kIterations)},
           {"map_reach_m", format_double(PclNdt::kReach_m)},
           {"points", std::to_string(kMostPoints)},
           {"resolution_m", format_double(map.cell_m)},
           {"step_m", format_double(PclNdt::kStep_m)},
           {"voxel_m", format_double(kVoxel_m)}}};
}

}  // namespace

std::unique_ptr<SiteLocalizer> make_site_localizer(const SiteLocalizerInputs& inputs) {
  if (inputs.choice.kind == LocalizerKind::kPclNdt) {
    return std::make_unique<PclSiteLocalizer>(inputs);
  }
  return std::make_unique<OwnSiteLocalizer>(inputs);
}

LocalizerProfile profile_of(const LocalizerChoice& choice, const NdtMap& map) {
  if (choice.kind == LocalizerKind::kPclNdt) return pcl_profile(map);
  return {std::string(localizer_name(choice.kind)),
          kLocalizersVersion,
          {{"cell_m", format_double(map.cell_m)},
           {"coarse_cells", std::to_string(choice.coarse_cells)},
           {"leaf_m", format_double(choice.leaf_m)}}};
}

}  // namespace sightline
