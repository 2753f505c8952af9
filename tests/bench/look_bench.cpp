#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/bench/looks/look_tables.h"

// How good and how dear is each look, the same everywhere? Towns of the generator are mapped
// by drive 0 and judged by drive 2 at every metre against the true pose, from 12 starts within 1 m.
// Prints for each look its coverage, and its work and time over those of static 50 m with every
// return, as fast as tests/bench/static_50m keeps it: the scan cut at 50 m, voxels of 1 m,
// searching localizer. Beside them stand Autoware's own sampling, matched by our searching
// localizer too (PCL's would take a hundred times as long), the oracle of the look, and for each of
// them the time of the best static look of equal coverage. The judging drive can be made harder
// than the one that mapped.

namespace sightline {
namespace {

struct Options {
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5, 6, 7, 8};
  double length_m = 600.0;
  int beams = 16;
  HarderDrive harder;
  std::vector<std::string> looks = usual_looks();
  MeasureOptions measure;
};

Result<std::vector<MeasuredRule>> rules_of(const std::vector<std::string>& looks) {
  std::vector<MeasuredRule> rules = {
      {.kind = MeasuredRule::Kind::kReference, .look = every_return(50.0)},
      {.kind = MeasuredRule::Kind::kAutoware, .look = every_return(60.0)}};
  for (const std::string& text : looks) {
    SIGHTLINE_ASSIGN(const MeasuredRule rule, parse_look_rule(text));
    rules.push_back(rule);
  }
  return rules;
}

Result<void> run(const Options& options) {
  SIGHTLINE_ASSIGN(const std::vector<MeasuredRule> rules, rules_of(options.looks));
  TownsFigures figures;
  for (const std::uint64_t seed : options.seeds) {
    const MappedTown town = make_mapped_town({.town = {.seed = seed, .length_m = options.length_m},
                                              .beams = options.beams,
                                              .harder = options.harder,
                                              .threads = options.measure.threads});
    figures.push_back(measure_looks(town, rules, options.measure));
    std::fprintf(stderr, "town %llu: %zu places\n", static_cast<unsigned long long>(seed),
                 town.scans.size());
  }
  print_looks(rules, figures);
  print_equal_coverage(rules, figures);
  return {};
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
  app.add_option("--rebuilt", options.harder.rebuilt_share,
                 "share of each 60 m of the route that was rebuilt since it was mapped")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--crowd", options.harder.traffic, "times the usual traffic")
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--missing", options.harder.missing_share, "share of returns that are missing")
      ->check(CLI::Range(0.0, 0.99));
  app.add_option("--leaf-m", options.measure.leaf_m, "voxels of the looks")
      ->check(CLI::Range(0.1, 10.0));
  app.add_option("--timed-every", options.measure.timed_every, "places: how many are timed");
  app.add_option("--threads", options.measure.threads, "0: all there are");
  CLI11_PARSE(app, argc, argv);
  const sightline::Result<void> done = sightline::run(options);
  if (!done) {
    std::fprintf(stderr, "%s\n", done.error().message.c_str());
    return 65;
  }
}
