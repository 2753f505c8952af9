#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/base/stopwatch.h"
#include "formats/drive/look.h"
#include "passes/matching/localizer.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/match_starts.h"
#include "tests/bench/mapped_town.h"
#include "tests/bench/static_50m/kernel_in_turn.h"

// How good and how dear is each look, the same everywhere? Towns of the generator are mapped
// by drive 0 and judged by drive 2 at every metre against the true pose, from 12 starts within 1 m.
// Prints for each look its coverage (share of places whose mean error over the starts is within the
// limit: mean over the towns, worst town), and its work and time over those of static 50 m with
// every return, as fast as tests/bench/static_50m keeps it: the scan cut at 50 m,
// voxels of 1 m, searching localizer. Time is thread CPU time
// of cut, preparation and match; before each the caches are emptied by writing 64 MiB, and all
// looks take turns at one place and start. "cut" is the part of it that comes before the match.

namespace sightline {
namespace {

// What a localization ends with, whoever ran it.
struct Found {
  Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
  int evaluations = 0;
  double work = 0.0, points = 0.0;
};

// How a look is run.
struct Rule {
  Look look;
  const Localizer& localizer;
  MatchOptions options;
  const KernelVersion* kernel = nullptr;  // null: the product's
};

// Keeps its memory from one scan to the next.
class Runner {
 public:
  explicit Runner(const Rule& rule) : rule_(rule) {}
  void cut(const MappedTown& town, std::size_t place, const Pose& T_map_start) {
    cutter_.cut(rule_.localizer, town.scans[place], town.sensor, rule_.look, T_map_start, cut_);
  }
  Found match(const Pose& T_map_start) {  // what was cut last
    const MatchResult result = rule_.look.mode == LookMode::kSettle
                                   ? settle(rule_.localizer, cut_, T_map_start, rule_.options)
                                   : localize(rule_.localizer, cut_, T_map_start, rule_.options);
    return {result.T_map_sensor.translation(), result.iterations, static_cast<double>(result.work),
            static_cast<double>(cut_.points_m.size())};
  }

 private:
  const Rule& rule_;
  LookCutter cutter_;
  ScanForMatch cut_;
};

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

Figures measure(const Rule& rule, const MappedTown& town, int threads) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  const auto starts = static_cast<double>(offsets.size());
  std::vector<PlaceFigures> places(town.scans.size());
  parallel_for(places.size(), threads, [&](std::size_t place) {
    Runner runner(rule);
    for (const InitialOffset& offset : offsets) {
      const Pose& truth = town.T_map_vehicle[place];
      const Pose T_map_start = truth * start_pose(offset);
      runner.cut(town, place, T_map_start);
      const Found found = runner.match(T_map_start);
      places[place].error_m += (found.p_map_m - truth.translation()).norm() / starts;
      places[place].work += found.work;
      places[place].evaluations += found.evaluations / starts;
      places[place].points += found.points / starts;
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

void measure_times(const std::vector<Rule>& rules, const MappedTown& town, std::size_t step,
                   std::vector<Figures>& figures) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  std::vector<Runner> runners(rules.begin(), rules.end());
  for (std::size_t place = 0; place < town.scans.size(); place += step) {
    const Pose T_map_start =
        town.T_map_vehicle[place] * start_pose(offsets[place / step % offsets.size()]);
    for (std::size_t m = 0; m < runners.size(); ++m) {
      replace_fastest_kernel(rules[m].kernel);
      empty_caches();
      const double begin_ms = thread_cpu_ms();
      runners[m].cut(town, place, T_map_start);
      const double middle_ms = thread_cpu_ms();
      runners[m].match(T_map_start);
      figures[m].time_ms += thread_cpu_ms() - begin_ms;
      figures[m].cut_ms += middle_ms - begin_ms;
    }
  }
  replace_fastest_kernel(nullptr);
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
  const MappedTown town = make_mapped_town({.seed = seed, .length_m = options.length_m},
                                           options.beams, options.threads);
  const Localizer searching =
      make_localizer(town.map, localizer_options(LocalizerKind::kSearching));
  const Localizer of_samples = make_localizer(town.map, options_for_samples());
  const KernelVersion in_turn = kernel_in_turn();
  std::vector<Rule> rules = {{every_return(50.0), searching, {}, &in_turn}};
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
