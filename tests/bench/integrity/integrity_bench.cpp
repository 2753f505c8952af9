// How wrong may a pose be? Drives of generated worlds, localized in a closed loop with wheel speed
// (2 % off), a gyro (0.02 degrees/s off) and a Kalman filter, with covariances of matches from
// several sources. One row a source and kind of place:
//   weak      scans with a direction that nothing constrains in truth
//   lost      matches 0.5 m off in a constrained direction; not counted in NEES
//   NEES      of matches, constrained directions, by degree of freedom, 1 is right; share inside
//             the 95 % region
//   returned  of the returned pose, given the filter's covariance; all directions
//   fused     of the filter's pose; all directions
//   errors    root mean squares, m and degrees; end: ahead, fused, where the kind of place ends

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "tests/bench/integrity/closed_loop.h"
#include "tests/bench/integrity/faults.h"
#include "tests/bench/integrity/loop_table.h"

namespace {

using namespace sightline;

struct Flags {
  std::vector<std::string> worlds = {"tunnel"};
  std::vector<std::uint64_t> seeds = {1};
  std::vector<std::string> sources = {"fixed", "laplace", "multi-ndt", "structure", "inflated"};
  IntegrityWorldOptions world;
  LoopOptions loop;
  double range_m = 50.0;
  std::uint32_t points = 0;
  std::string samples;
  bool has_faults = false;
};

Look look_of(const Flags& flags) {
  Look look;
  look.range_m = flags.range_m;
  if (flags.points == 0) return look;
  look.range_m = 100.0;
  look.return_count = 2000;
  look.even_beyond_m = 30.0;
  look.point_count = flags.points;
  look.is_by_normals = true;
  return look;
}

CovarianceSource source_of(const std::string& name) {
  for (const CovarianceSource source :
       {CovarianceSource::kFixed, CovarianceSource::kLaplace, CovarianceSource::kMultiNdt}) {
    if (name == source_name(source)) return source;
  }
  return CovarianceSource::kStructure;
}

// One line a scan, for fits outside: kind, seed, scan, constrained ahead and left; then, of six
// motions in the vehicle's axes, end and start of the match, descent, and the upper triangle of the
// structures' information; likelihood, points, scored points, raised points met and
// all; errors of the filter: 3.
void write_samples(std::ofstream& file, const IntegrityWorld& world,
                   const std::vector<LoopStep>& steps) {
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const LoopStep& s = steps[k];
    if (!s.is_matched) continue;
    file << s.kind << ' ' << world.seed << ' ' << k << ' ' << s.is_constrained[0] << ' '
         << s.is_constrained[1];
    for (int i = 0; i < 6; ++i) file << ' ' << s.sample.found[i];
    for (int i = 0; i < 6; ++i) file << ' ' << s.sample.start[i];
    for (int i = 0; i < 6; ++i) file << ' ' << s.sample.structure.descent[i];
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) file << ' ' << s.sample.structure.information(i, j);
    }
    file << ' ' << s.sample.likelihood << ' ' << s.sample.point_count << ' '
         << s.sample.scored_points << ' ' << s.sample.structure.raised.met_count << ' '
         << s.sample.structure.raised.count;
    for (int i = 0; i < 3; ++i) file << ' ' << s.fused_error[i];
    file << '\n';
  }
}

int run(const Flags& flags) {
  std::map<std::string, LoopSummaries> all;
  FaultTable faults;
  std::ofstream samples;
  if (!flags.samples.empty()) samples.open(flags.samples);
  std::size_t worlds = 0;
  std::size_t count = 0;
  double match_s = 0.0;
  double information_s = 0.0;
  for (const std::string& name : flags.worlds) {
    for (const std::uint64_t seed : flags.seeds) {
      IntegrityWorldOptions making = flags.world;
      making.world = name;
      making.seed = seed;
      const Result<IntegrityWorld> world = make_integrity_world(making);
      if (!world) {
        std::fprintf(stderr, "%s\n", to_string(world.error()).c_str());
        return 1;
      }
      ++worlds;
      WorldLocalizer localizer(*world, look_of(flags));
      for (std::size_t d = 0; d < world->drives.size(); ++d) {
        if (flags.has_faults) add_faults(localizer, world->drives[d], faults);
        for (const std::string& source : flags.sources) {
          LoopOptions options = flags.loop;
          options.source = source_of(source);
          if (source != "inflated") options.inflation = 1.0;
          options.seed = mix(seed, making.drives[d]);
          const double before_s = localizer.match_s();
          const double information_before_s = localizer.information_s();
          const std::vector<LoopStep> steps =
              drive_closed_loop(localizer, world->drives[d], options);
          add_loop(steps, all[source]);
          if (source == "structure") {
            match_s += localizer.match_s() - before_s;
            information_s += localizer.information_s() - information_before_s;
            count += steps.size();
          }
          if (samples && source == "structure") write_samples(samples, *world, steps);
        }
      }
    }
  }
  std::printf("%zu worlds of %.0f m, drives: %zu each\n", worlds, flags.world.length_m,
              flags.world.drives.size());
  if (count > 0) {
    std::printf("information of a match: %.1f us, %.1f %% of the time of cut and match\n",
                1e6 * information_s / static_cast<double>(count), 100.0 * information_s / match_s);
  }
  print_heading();
  for (const auto& [source, summaries] : all) {
    for (const auto& [kind, summary] : summaries) print_row(source, kind, summary);
  }
  if (flags.has_faults) print_faults(faults);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  CLI::App app("Consistency of covariances of matches, and of what a filter makes of them.");
  app.add_option("--worlds", flags.worlds, "kinds of hard worlds, or town-streets")->delimiter(',');
  app.add_option("--seeds", flags.seeds)->delimiter(',');
  app.add_option("--drives", flags.world.drives, "1 and up")->delimiter(',');
  app.add_option("--length-m", flags.world.length_m);
  app.add_option("--beams", flags.world.beams);
  app.add_option("--threads", flags.world.threads);
  app.add_option("--constraints-m", flags.world.constraints_every_m,
                 "m between scans whose true constraints are computed");
  app.add_option("--sources", flags.sources)->delimiter(',');
  app.add_option("--range-m", flags.range_m, "of a look of every return");
  app.add_option("--points", flags.points, "of a look of so many points instead");
  app.add_option("--factor", flags.loop.scale.variance_factor);
  app.add_option("--map-m", flags.loop.scale.map_m);
  app.add_option("--map-rad", flags.loop.scale.map_rad);
  app.add_option("--rival-factor", flags.loop.rival_factor);
  app.add_option("--inflation", flags.loop.inflation,
                 "of source inflated: structure, whose covariances are so many times larger for "
                 "the filter, since errors of successive scans are correlated");
  app.add_flag("--tracking-starts", flags.loop.has_tracking_starts,
               "start each match 0.2 m and 0.5 degrees off instead of at the filter's prediction");
  app.add_flag("--faults", flags.has_faults, "pull poses off sideways too");
  app.add_option("--samples", flags.samples, "a file for errors and structures of each scan");
  CLI11_PARSE(app, argc, argv);
  return run(flags);
}
