#include "passes/localize/site_localizer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {
namespace {

class OwnSiteLocalizer : public SiteLocalizer {
 public:
  explicit OwnSiteLocalizer(const SiteLocalizerInputs& inputs)
      : matcher_({inputs.own, inputs.of_samples, inputs.sensor, inputs.choice.leaf_m,
                  inputs.choice.takes_every_return, /*shares_climbs=*/true}) {}
  void go_to(const Eigen::Vector3d& /*p_map_m*/, std::uint64_t /*seed*/) override {}
  void take(const Scan& scan, const Look& look) override { matcher_.take(scan, look); }
  MatchResult match(const Pose& T_map_start) override { return matcher_.match(T_map_start); }
  [[nodiscard]] std::size_t point_count() const override { return matcher_.point_count(); }
  [[nodiscard]] double taken_over_ms() const override { return matcher_.taken_over_ms(); }

 private:
  LookMatcher matcher_;
};

// The range is ours: what lies beyond it was not looked at.
class PclSiteLocalizer : public SiteLocalizer {
 public:
  explicit PclSiteLocalizer(const SiteLocalizerInputs& inputs) : inputs_(inputs) {}
  void go_to(const Eigen::Vector3d& p_map_m, std::uint64_t seed) override {
    ndt_.emplace(inputs_.map, p_map_m);
    seed_ = seed;
  }
  void take(const Scan& scan, const Look& look) override {
    const std::uint64_t seed = mix(seed_, std::bit_cast<std::uint64_t>(look.range_m));
    const std::vector<Eigen::Vector3d> points_m =
        sampler_.sample(scan, inputs_.sensor, look.range_m, seed);
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
  AutowareSampler sampler_;
  std::optional<PclNdt> ndt_;
  std::uint64_t seed_ = 0;
  std::size_t point_count_ = 0;
};

LocalizerProfile pcl_profile(double cell_m) {
  return {"pcl-ndt",
          kLocalizersVersion,
          {{"box_m", format_double(AutowareSampler::kBox_m)},
           {"epsilon_m", format_double(PclNdt::kEpsilon_m)},
           {"iterations", std::to_string(PclNdt::kIterations)},
           {"map_reach_m", format_double(PclNdt::kReach_m)},
           {"points", std::to_string(AutowareSampler::kMostPoints)},
           {"resolution_m", format_double(cell_m)},
           {"step_m", format_double(PclNdt::kStep_m)},
           {"voxel_m", format_double(AutowareSampler::kVoxel_m)}}};
}

}  // namespace

std::unique_ptr<SiteLocalizer> make_site_localizer(const SiteLocalizerInputs& inputs) {
  if (inputs.choice.kind == LocalizerKind::kPclNdt) {
    return std::make_unique<PclSiteLocalizer>(inputs);
  }
  return std::make_unique<OwnSiteLocalizer>(inputs);
}

LocalizerProfile profile_of(const LocalizerChoice& choice, double cell_m) {
  if (choice.kind == LocalizerKind::kPclNdt) return pcl_profile(cell_m);
  LocalizerProfile profile{std::string(localizer_name(choice.kind)),
                           kLocalizersVersion,
                           {{"cell_m", format_double(cell_m)},
                            {"coarse_cells", std::to_string(choice.coarse_cells)},
                            {"leaf_m", format_double(choice.leaf_m)}}};
  if (choice.takes_every_return) profile.parameters.emplace_back(kEveryReturn);
  return profile;
}

}  // namespace sightline
