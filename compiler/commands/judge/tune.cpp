#include <algorithm>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/watched_work.h"
#include "compiler/cli/result_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/replay/tuning_report.h"
#include "passes/localize/measure_error.h"
#include "passes/localize/pcl/pcl_ndt.h"

namespace sightline {
namespace {

struct TuneFlags {
  RunFlags run;
  ResultFlags result;
  std::string localizer = "pcl-ndt";
  double limit_m = 0.0;
  int most_scans = 48;
};

Result<CompileConfig> tuned_config(const TuneFlags& flags) {
  if (!has_pcl_ndt()) {
    return Error{ErrorCode::kBadValue,
                 "--localizer pcl-ndt: this program was built without PCL; tests/support/setup "
                 "installs its package libpcl-dev and builds the program with it",
                 "", ""};
  }
  SIGHTLINE_ASSIGN(CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  if (config.has_map() && config.localization.scans.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "localization.scans: numbers are chosen by a drive; name one for this finished "
                 "map",
                 flags.run.config_file};
  }
  return config;
}

// Position of the limit among those of the configuration.
Result<std::size_t> limit_of(const TuneFlags& flags, const std::vector<double>& limits_m) {
  const double limit_m = flags.limit_m > 0.0 ? flags.limit_m : std::ranges::min(limits_m);
  const auto found = std::ranges::find(limits_m, limit_m);
  if (found != limits_m.end()) return static_cast<std::size_t>(found - limits_m.begin());
  std::vector<std::string> names;
  for (const double known_m : limits_m) names.push_back(format_double(known_m));
  return Error{ErrorCode::kBadValue,
               concat("--limit: found ", format_double(flags.limit_m), ", expected one of ",
                      joined(names), " (annotation.limits_m)"),
               "", ""};
}

// As a compile measures its localization drive.
Result<TuneNdtOptions> tuning_options(const TuneFlags& flags, const CompileConfig& config) {
  const MeasureErrorOptions measuring = config.passes.options(kMeasureError);
  TuneNdtOptions options;
  options.limits_m = config.annotation.limits_m;
  SIGHTLINE_ASSIGN(options.limit, limit_of(flags, options.limits_m));
  options.scans = config.is_split() ? ScanSelection::kOdd : ScanSelection::kAll;
  options.reference = measuring.reference;
  options.site_radius_m = measuring.site_radius_m;
  options.tracking = measuring.tracking;
  options.most_scans = static_cast<std::size_t>(flags.most_scans);
  return options;
}

Result<void> tune(const TuneFlags& flags) {
  SIGHTLINE_TRY(try_result(flags.result));
  SIGHTLINE_ASSIGN(const CompileConfig config, tuned_config(flags));
  SIGHTLINE_ASSIGN(TuneNdtOptions options, tuning_options(flags, config));
  const CompilePlan compile = compile_plan(config);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(flags.run), artifacts));
  const LocalizedDrive& drive = compile.localized;
  const std::vector<AnyWire> wanted = {compile.ndt, compile.sites, drive.undistorted,
                                       drive.trajectory};
  SIGHTLINE_TRY(run_steps(compile.plan, wanted, flags.run, config, artifacts));
  if (!std::ranges::all_of(wanted, [&](AnyWire wire) { return artifacts.has(wire); })) {
    say_stopped(flags.run, "no numbers are tried");
    return {};
  }
  const Trajectory& trajectory = artifacts.get(drive.trajectory);
  if (trajectory.source == PoseSource::kEstimated) {
    options.reference = ErrorReference::kFullRangeMatch;
  }
  NdtTuning found;
  SIGHTLINE_TRY(do_watched(
      {"tune", flags.run.threads, flags.run.json_progress, {}},
      [&](PassContext& ctx) -> Result<void> {
        ctx.seed = static_cast<std::uint64_t>(config.annotation.seed);
        SIGHTLINE_ASSIGN(found, tune_ndt(ctx, options, artifacts.get(drive.undistorted), trajectory,
                                         artifacts.get(compile.ndt), artifacts.get(compile.sites)));
        return {};
      }));
  return put_result(flags.result, flags.result.is_json() ? to_json(found) : to_text(found));
}

}  // namespace

Verb tune_verb() {
  const auto flags = std::make_shared<TuneFlags>();
  Verb verb;
  verb.name = "tune";
  verb.summary = "Find the numbers with which another localizer suits a route";
  verb.details =
      "For a vehicle that keeps its localizer: NDT of PCL, as in Autoware's ndt_scan_matcher. The "
      "NDT itself is left as it is. Crop box, voxel size and number of points of the filters "
      "before it are tried in every combination, on scans of the localization drive (of one drive "
      "alone: those that did not make the map), each from the poses of a vehicle that tracks.\n\n"
      "Every second scan chooses, the others judge. Prints how often Autoware's own numbers end "
      "within the limit, and their cost; the least work of the combinations that end within it as "
      "often; and the combination that ends within it most often. Where the scans that judge do "
      "not confirm a gain, nothing is recommended. A map may name a range for each place instead: "
      "`sightline compile` with "
      "measure-error.localizer=pcl-ndt.";
  verb.examples = {"sightline tune town.yaml --localizer pcl-ndt",
                   "sightline tune town.yaml --localizer pcl-ndt --limit 0.25",
                   "sightline tune town.yaml --localizer pcl-ndt --format json -o tuned.json"};
  verb.flags = {{.names = "--localizer",
                 .value = "NAME",
                 .help = "The localizer that stays; pcl-ndt: NDT of PCL after Autoware's filters",
                 .target = &flags->localizer,
                 .choices = {"pcl-ndt"}},
                {.names = "--limit",
                 .value = "METRES",
                 .help = "One of the map's limits; 0: the tightest",
                 .target = &flags->limit_m,
                 .minimum = 0.0},
                {.names = "--scans",
                 .value = "COUNT",
                 .help = "Scans to use at most, evenly along the drive",
                 .target = &flags->most_scans,
                 .minimum = 2,
                 .maximum = 10000}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json as schemas/tune.schema.json describes it");
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(tune(*flags)); };
  return verb;
}

}  // namespace sightline
