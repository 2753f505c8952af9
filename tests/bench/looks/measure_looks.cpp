#include "tests/bench/looks/measure_looks.h"
#include "tests/bench/bench_tools.h"

#include <charconv>

#include "formats/base/parallel.h"
#include "formats/base/stopwatch.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_cutter.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

namespace sightline {
namespace {

using Kind = MeasuredRule::Kind;

// The town's map, ready for both ways to match.
struct Localizers {
  Localizer searching;
  Localizer of_samples;
};

// What a localization ends with, for any localizer.
struct Found {
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  int evaluations = 0;
  double work = 0.0, points = 0.0;
};

// Keeps its memory from one scan to the next.
class Runner {
 public:
  Runner(const MeasuredRule& rule, const Localizers& localizers, double leaf_m)
      : rule_(rule),
        localizer_(rule.kind == Kind::kLook ? localizers.of_samples : localizers.searching),
        cutter_(rule.kind == Kind::kLook ? leaf_m : 1.0) {
    if (rule.kind == Kind::kLook) options_.stop_step_m = kSampleStop_m;
  }

  void cut(const MappedTown& town, std::size_t place, const Pose& T_map_start) {
    const Scan& scan = town.scans[place];
    if (rule_.kind == Kind::kAutoware) {
      fill(autoware_.sample(scan, town.sensor, AutowareFilters(), place));
    } else if (rule_.voxels_apart > 1) {
      cut_every_nth(scan, town.sensor);
    } else {
      cutter_.cut(localizer_, scan, town.sensor, rule_.look, T_map_start, cut_);
    }
  }

  Found match(const Pose& T_map_start) {  // what was cut last
    const MatchResult result = rule_.look.mode == LookMode::kSettle
                                   ? settle(localizer_, cut_, T_map_start, options_)
                                   : localize(localizer_, cut_, T_map_start, options_);
    return {result.T_map_sensor.translation(), result.iterations, static_cast<double>(result.work),
            static_cast<double>(cut_.points_m.size())};
  }

 private:
  void cut_every_nth(const Scan& scan, const SensorProfile& sensor) {
    const std::span<const Eigen::Vector3d> all_m = cutter_.candidates(scan.points_m, rule_.look);
    points_m_.clear();
    for (std::size_t i = 0; i < all_m.size(); i += rule_.voxels_apart) {
      points_m_.push_back(sensor.T_vehicle_lidar * all_m[i]);
    }
    fill(points_m_);
  }
  void fill(std::span<const Eigen::Vector3d> points_m) {
    fill_scan_for_match(points_m, lead_stride(localizer_, points_m.size()), cut_);
  }

  const MeasuredRule& rule_;
  const Localizer& localizer_;
  MatchOptions options_;
  LookCutter cutter_;
  AutowareSampler autoware_;
  std::vector<Eigen::Vector3d> points_m_;
  ScanForMatch cut_;
};

RuleFigures measure(const MeasuredRule& rule, const Localizers& localizers, const MappedTown& town,
                    const MeasureOptions& options) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  const auto starts = static_cast<double>(offsets.size());
  RuleFigures places(town.scans.size());
  parallel_for(places.size(), options.threads, [&](std::size_t place) {
    Runner runner(rule, localizers, options.leaf_m);
    PlaceFigures& figures = places[place];
    for (const InitialOffset& offset : offsets) {
      const Pose& truth = town.T_map_vehicle[place];
      const Pose T_map_start = truth * start_pose(offset);
      runner.cut(town, place, T_map_start);
      const Found found = runner.match(T_map_start);
      figures.error_m += (found.p_map_m - truth.translation()).norm() / starts;
      figures.work += found.work;
      figures.evaluations += found.evaluations / starts;
      figures.points += found.points / starts;
    }
  });
  return places;
}

void measure_times(std::span<const MeasuredRule> rules, const Localizers& localizers,
                   const MappedTown& town, const MeasureOptions& options,
                   std::vector<RuleFigures>& figures) {
  const std::size_t step = options.timed_every;
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  const KernelVersion in_turn = kernel_in_turn();
  std::vector<Runner> runners;
  for (const MeasuredRule& rule : rules) runners.emplace_back(rule, localizers, options.leaf_m);
  for (std::size_t place = 0; place < town.scans.size(); place += step) {
    const Pose T_map_start =
        town.T_map_vehicle[place] * start_pose(offsets[place / step % offsets.size()]);
    for (std::size_t i = 0; i < runners.size(); ++i) {
      replace_fastest_kernel(rules[i].kind == Kind::kReference ? &in_turn : nullptr);
      empty_caches();
      const double begin_ms = thread_cpu_ms();
      runners[i].cut(town, place, T_map_start);
      const double middle_ms = thread_cpu_ms();
      runners[i].match(T_map_start);
      const double end_ms = thread_cpu_ms();
      PlaceFigures& timed = figures[i][place];
      timed.is_timed = true;
      timed.time_ms = end_ms - begin_ms;
      timed.cut_ms = middle_ms - begin_ms;
    }
  }
  replace_fastest_kernel(nullptr);
}

constexpr std::string_view kOneIn = ", one voxel in ";

}  // namespace

std::vector<RuleFigures> measure_looks(const MappedTown& town, std::span<const MeasuredRule> rules,
                                       const MeasureOptions& options) {
  const Localizers localizers = {
      make_localizer(town.map, localizer_options(LocalizerKind::kSearching)),
      make_localizer(town.map, options_for_samples())};
  std::vector<RuleFigures> figures;
  for (const MeasuredRule& rule : rules)
    figures.push_back(measure(rule, localizers, town, options));
  measure_times(rules, localizers, town, options, figures);
  return figures;
}

bool needs_normals(const MeasuredRule& rule) {
  return rule.kind == MeasuredRule::Kind::kLook && rule.look.is_by_normals;
}

std::string to_text(const MeasuredRule& rule) {
  if (rule.kind == MeasuredRule::Kind::kReference) return "50 m, every return, searching";
  if (rule.kind == MeasuredRule::Kind::kAutoware) {
    return "Autoware's sampling: 60 m, voxels of 3 m, 1500 at random";
  }
  std::string text = to_text(rule.look);
  if (rule.voxels_apart > 1) text += std::string(kOneIn) + std::to_string(rule.voxels_apart);
  return text;
}

Result<MeasuredRule> parse_look_rule(std::string_view text) {
  MeasuredRule rule;
  const std::size_t one_in = text.rfind(kOneIn);
  if (one_in != std::string_view::npos) {
    const char* begin = text.data() + one_in + kOneIn.size();
    const char* end = text.data() + text.size();
    const std::from_chars_result read = std::from_chars(begin, end, rule.voxels_apart);
    if (read.ptr != end || read.ec != std::errc() || rule.voxels_apart < 1) {
      return Error{ErrorCode::kBadArgument,
                   "'" + std::string(text) + "' does not say one voxel in how many",
                   {},
                   {}};
    }
    text = text.substr(0, one_in);
  }
  SIGHTLINE_ASSIGN(rule.look, parse_look(text));
  if (rule.voxels_apart > 1 && (takes_every_return(rule.look) || rule.look.point_count > 0)) {
    return Error{
        ErrorCode::kBadArgument,
        "'" + std::string(text) + "', one voxel in so many: expected returns and no points",
        {},
        {}};
  }
  return rule;
}

std::vector<std::string> usual_looks() {
  return {"100 m, 650 returns, evenly spaced beyond 30 m, 80 points",
          "100 m, 1000 returns, evenly spaced beyond 40 m, 80 points",
          "100 m, 1300 returns, evenly spaced beyond 40 m, 100 points",
          "100 m, 2850 returns, evenly spaced beyond 50 m, 100 points",
          "100 m, 4000 returns, evenly spaced beyond 50 m, 256 points",
          "100 m, 6000 returns, evenly spaced beyond 50 m, 384 points",
          "100 m, 8000 returns, evenly spaced beyond 50 m, 512 points",
          "100 m, 400 returns, evenly spaced beyond 20 m, 32 points by normals",
          "100 m, 650 returns, evenly spaced beyond 30 m, 40 points by normals",
          "100 m, 1000 returns, evenly spaced beyond 30 m, 64 points by normals",
          "100 m, 1944 returns, evenly spaced beyond 40 m, 80 points by normals",
          "100 m, 2850 returns, evenly spaced beyond 40 m, 100 points by normals",
          "100 m, 4000 returns, evenly spaced beyond 50 m, 128 points by normals",
          "100 m, 6000 returns, evenly spaced beyond 50 m, 256 points by normals",
          "50 m, 1944 returns, evenly spaced beyond 50 m, 250 points",
          "50 m, 1944 returns, evenly spaced beyond 30 m, 80 points by normals"};
}

}  // namespace sightline
