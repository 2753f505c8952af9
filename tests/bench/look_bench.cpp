#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "examples/town/drive.h"
#include "formats/annotation/look.h"
#include "formats/base/parallel.h"
#include "formats/base/stopwatch.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/match_starts.h"

// How good and how dear is each look, the same everywhere? Towns of the generator are mapped by
// drive 0 and judged by drive 2 at every metre against the true pose, from 12 starts within 1 m.
// Prints for each look its coverage (share of places whose mean error over the starts is within the
// limit: mean over the towns, worst town), and its work and time over those of static 50 m with
// every return: the scan cut at 50 m, voxels of 1 m, searching localizer. Time is thread CPU time
// of cut, preparation and match; before each the caches are emptied by writing 64 MiB, and all
// looks take turns at one place and start. "cut" is the part of it that comes before the match.

namespace sightline {
namespace {

struct Town {
  NdtMap map;
  SensorProfile sensor;
  std::vector<Scan> scans;
  std::vector<Pose> T_map_vehicle;  // true
};

std::vector<Eigen::Vector3d> points_of(const town::TownScan& scan, bool is_map) {
  std::vector<Eigen::Vector3d> points_m;
  for (const town::LabelledPoint& point : scan.points) {
    if (!is_map || !is_moving(point.label)) points_m.push_back(point.position_m.cast<double>());
  }
  return points_m;
}

Town make_town(const town::TownOptions& options, int beams, int threads) {
  const town::Town street = *town::make_town(options);
  Town town;
  town.sensor = *town::town_sensor(beams);
  const auto drive = [&](std::uint64_t number) {
    return *town::DriveSimulator::make(street, town::usual_drive(options, number, town.sensor));
  };
  const town::DriveSimulator mapping = drive(0);
  town.sensor = mapping.sensor();
  const std::vector<Pose> T_map_given = mapping.disturbed_poses();
  const std::vector<town::TownScan> mapped = town::simulate(mapping, threads);
  std::vector<Eigen::Vector3d> map_points_m;
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    const Pose T_map_lidar = T_map_given[i] * town.sensor.T_vehicle_lidar;
    for (const Eigen::Vector3d& p_m : points_of(mapped[i], true)) {
      map_points_m.push_back(T_map_lidar * p_m);
    }
  }
  town.map = ndt_from_points(map_points_m, MapFrame{}, BuildNdtOptions{}, threads);
  for (const town::TownScan& scan : town::simulate(drive(2), threads)) {
    town.scans.emplace_back();
    town.scans.back().points_m = points_of(scan, false);
    town.T_map_vehicle.push_back(scan.T_town_vehicle);
  }
  return town;
}

// How a look is run.
struct Rule {
  Look look;
  const Localizer& localizer;
  MatchOptions options;
};

MatchResult run(const Rule& rule, const Town& town, std::size_t place, const Pose& T_map_start,
                LookCutter& cutter, ScanForMatch& cut) {
  cutter.cut(rule.localizer, town.scans[place], town.sensor, rule.look, T_map_start, cut);
  if (rule.look.mode == LookMode::kSettle) {
    return settle(rule.localizer, cut, T_map_start, rule.options);
  }
  return localize(rule.localizer, cut, T_map_start, rule.options);
}

constexpr std::array<double, 2> kLimits_m = {0.10, 0.25};

// Of one look in one town.
struct Figures {
  std::array<double, 2> coverage{};
  double median_m = 0.0;
  double points = 0.0, evaluations = 0.0;  // means
  double work = 0.0;                       // sum
  double time_ms = 0.0, cut_ms = 0.0;      // sums over the places that were timed
};

struct PlaceFigures {
  double error_m = 0.0, points = 0.0, evaluations = 0.0, work = 0.0;
};

Figures measure(const Rule& rule, const Town& town, int threads) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  const auto starts = static_cast<double>(offsets.size());
  std::vector<PlaceFigures> places(town.scans.size());
  parallel_for(places.size(), threads, [&](std::size_t place) {
    LookCutter cutter;
    ScanForMatch cut;
    for (const InitialOffset& offset : offsets) {
      const Pose& truth = town.T_map_vehicle[place];
      const MatchResult found = run(rule, town, place, truth * start_pose(offset), cutter, cut);
      places[place].error_m +=
          (found.T_map_sensor.translation() - truth.translation()).norm() / starts;
      places[place].work += static_cast<double>(found.work);
      places[place].evaluations += found.iterations / starts;
      places[place].points += static_cast<double>(cut.points_m.size()) / starts;
    }
  });
  Figures figures;
  const auto count = static_cast<double>(places.size());
  for (const PlaceFigures& place : places) {
    for (std::size_t l = 0; l < kLimits_m.size(); ++l) {
      figures.coverage[l] += (place.error_m <= kLimits_m[l] ? 1.0 : 0.0) / count;
    }
    figures.work += place.work;
    figures.points += place.points / count;
    figures.evaluations += place.evaluations / count;
  }
  std::ranges::sort(places, {}, &PlaceFigures::error_m);
  figures.median_m = places[places.size() / 2].error_m;
  return figures;
}

void empty_caches() {
  static std::vector<char> memory(std::size_t{64} << 20);
  static char value = 0;
  std::memset(memory.data(), ++value, memory.size());
}

void measure_times(const std::vector<Rule>& rules, const Town& town, std::size_t step,
                   std::vector<Figures>& figures) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  LookCutter cutter;
  ScanForMatch cut;
  for (std::size_t place = 0; place < town.scans.size(); place += step) {
    const Pose T_map_start =
        town.T_map_vehicle[place] * start_pose(offsets[place / step % offsets.size()]);
    for (std::size_t r = 0; r < rules.size(); ++r) {
      empty_caches();
      const double begin_ms = thread_cpu_ms();
      run(rules[r], town, place, T_map_start, cutter, cut);
      const double end_ms = thread_cpu_ms();
      figures[r].time_ms += end_ms - begin_ms;
      empty_caches();
      const double cut_begin_ms = thread_cpu_ms();
      cutter.cut(rules[r].localizer, town.scans[place], town.sensor, rules[r].look, T_map_start,
                 cut);
      figures[r].cut_ms += thread_cpu_ms() - cut_begin_ms;
    }
  }
}

// Over the towns; the first look is the one that all are compared with.
void print_row(const std::string& name, const std::vector<Figures>& of_town,
               const std::vector<Figures>& reference) {
  const auto count = static_cast<double>(of_town.size());
  Figures mean;
  std::array<double, 2> worst = {1.0, 1.0};
  for (std::size_t town = 0; town < of_town.size(); ++town) {
    const Figures& figures = of_town[town];
    for (std::size_t l = 0; l < worst.size(); ++l) {
      mean.coverage[l] += figures.coverage[l] / count;
      worst[l] = std::min(worst[l], figures.coverage[l]);
    }
    mean.median_m += figures.median_m / count;
    mean.points += figures.points / count;
    mean.evaluations += figures.evaluations / count;
    mean.work += figures.work / reference[town].work / count;
    mean.time_ms += figures.time_ms / reference[town].time_ms / count;
    mean.cut_ms += figures.cut_ms / reference[town].time_ms / count;
  }
  std::printf("%5.1f (%5.1f)  %5.1f (%5.1f)  %3.1f cm  %5.0f  %5.1f  %.3f  %.3f  %.3f  %s\n",
              100.0 * mean.coverage[0], 100.0 * worst[0], 100.0 * mean.coverage[1],
              100.0 * worst[1], 100.0 * mean.median_m, mean.points, mean.evaluations, mean.work,
              mean.time_ms, mean.cut_ms, name.c_str());
}

// The frontier: without a map, and by the normals of the map's NDs.
const std::vector<std::string> kLooks = {
    "50 m, 1944 returns, even beyond 50 m, 250 points",
    "50 m, 1944 returns, even beyond 30 m, 80 points by normals",
    "100 m, 1944 returns, even beyond 30 m, 80 points",
    "100 m, 1944 returns, even beyond 30 m, 150 points",
    "100 m, 2850 returns, even beyond 30 m, 250 points",
    "100 m, 1300 returns, even beyond 30 m, 64 points by normals",
    "100 m, 1944 returns, even beyond 30 m, 80 points by normals",
    "100 m, 1944 returns, even beyond 30 m, 100 points by normals",
    "100 m, 2850 returns, even beyond 30 m, 150 points by normals",
    "100 m, 4000 returns, even beyond 30 m, 250 points by normals"};

struct Options {
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5, 6, 7, 8};
  double length_m = 600.0;
  int beams = 16;
  std::vector<std::string> looks = kLooks;
  std::size_t timed_every = 10;
  int threads = 0;
};

Result<std::vector<Look>> parse_looks(const std::vector<std::string>& texts) {
  std::vector<Look> looks;
  for (const std::string& text : texts) {
    const Result<Look> look = parse_look(text);
    if (!look) return look.error();
    looks.push_back(*look);
  }
  return looks;
}

// Static 50 m by the searching localizer, then each look by the one for samples.
std::vector<Figures> measure_town(const Options& options, const std::vector<Look>& looks,
                                  std::uint64_t seed) {
  const Town town =
      make_town({.seed = seed, .length_m = options.length_m}, options.beams, options.threads);
  const Localizer searching =
      make_localizer(town.map, localizer_options(LocalizerKind::kSearching));
  const Localizer of_samples = make_localizer(town.map, options_for_samples());
  std::vector<Rule> rules = {{every_return(50.0), searching, {}}};
  for (const Look& look : looks) {
    rules.push_back({look, of_samples, {.stop_step_m = kSampleStop_m}});
  }
  std::vector<Figures> figures;
  for (const Rule& rule : rules) figures.push_back(measure(rule, town, options.threads));
  measure_times(rules, town, options.timed_every, figures);
  std::fprintf(stderr, "town %llu: %zu places\n", static_cast<unsigned long long>(seed),
               town.scans.size());
  return figures;
}

void print_looks(const Options& options, const std::vector<Look>& looks) {
  std::vector<std::vector<Figures>> of_look(looks.size() + 1);
  for (const std::uint64_t seed : options.seeds) {
    const std::vector<Figures> figures = measure_town(options, looks, seed);
    for (std::size_t i = 0; i < figures.size(); ++i) of_look[i].push_back(figures[i]);
  }
  std::printf("10 cm (worst)   25 cm (worst)  median  points  runs   work   time   cut  look\n");
  print_row("50 m, every return, searching", of_look[0], of_look[0]);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    print_row(to_text(looks[i]), of_look[i + 1], of_look[0]);
  }
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  sightline::Options options;
  CLI::App app{"Coverage, work and time of looks, the same everywhere, in generated towns"};
  app.add_option("--seeds", options.seeds, "towns");
  app.add_option("--length-m", options.length_m, "of each");
  app.add_option("--beams", options.beams, "of the sensor: 16, 32, 64 or 128");
  app.add_option("--look", options.looks, "a look as text; may be repeated");
  app.add_option("--timed-every", options.timed_every, "places: how many are timed");
  app.add_option("--threads", options.threads, "0: all there are");
  CLI11_PARSE(app, argc, argv);
  const sightline::Result<std::vector<sightline::Look>> looks =
      sightline::parse_looks(options.looks);
  if (!looks) {
    std::fprintf(stderr, "%s\n", looks.error().message.c_str());
    return 65;
  }
  sightline::print_looks(options, *looks);
}
