#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/file_kind.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/verdict_output.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/known_drive.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/report/report.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/diff/diff_maps.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct ReportFlags {
  RunFlags run;            // its configuration is the positional where --map names the map
  std::string map;         // empty: the positional is the map
  std::string against;     // an older map; empty: none
  std::string gate;        // what `gate --json` wrote; empty: none
  std::string evaluation;  // JSON of `evaluate`, for the verdict; empty: none
  std::string output;
  bool is_forced = false;

  [[nodiscard]] bool is_of_map_alone() const { return map.empty(); }
  [[nodiscard]] const std::string& map_file() const {
    return is_of_map_alone() ? run.config_file : map;
  }
};

// A plan and what was made by it.
template <class AnyPlan>
struct Made {
  AnyPlan plan;
  ArtifactSet artifacts;
};

// What the compile made on its way to the map, from the cache where it can.
Result<Made<CompilePlan>> made_on_the_way(const ReportFlags& flags, const CompileConfig& config) {
  Made<CompilePlan> made{compile_plan(config, ModelSource::kGiven), {}};
  const CompilePlan& plan = made.plan;
  SIGHTLINE_TRY(provide_drives(plan, cache_directory(flags.run), made.artifacts));
  std::vector<AnyWire> wanted = {plan.ndt, plan.surface, plan.sites, plan.depth};
  if (plan.points.is_connected()) wanted.push_back(plan.points);
  if (plan.trajectory.is_connected()) wanted.push_back(plan.trajectory);
  if (config.evaluation.scans.empty()) wanted.push_back(plan.measured);
  SIGHTLINE_TRY(run_steps(plan.plan, wanted, flags.run, config, made.artifacts));
  return made;
}

template <class X>
Digest digest_of(const X& artifact) {
  return sha256(to_bytes(artifact));
}

// The same cells from the same points; a map stores their covariances shorter.
bool are_same(const NdtMap& a, const NdtMap& b) {
  return a.cell_m == b.cell_m && std::equal(a.nds.begin(), a.nds.end(), b.nds.begin(), b.nds.end(),
                                            [](const Nd& left, const Nd& right) {
                                              return left.key == right.key &&
                                                     left.point_count == right.point_count;
                                            });
}

Result<void> check_same_map(const ReportFlags& flags, const CompiledMap& map,
                            const Made<CompilePlan>& made) {
  const bool is_same = are_same(map.ndt, made.artifacts.get(made.plan.ndt)) &&
                       digest_of(map.sites) == digest_of(made.artifacts.get(made.plan.sites));
  if (is_same) return {};
  return Error{
      ErrorCode::kMismatchedInputs,
      "the configuration makes other NDs or sites than this map holds; compile it again, or "
      "give the configuration and --set with which it was compiled",
      flags.map_file()};
}

// Judged by the evaluation drive where the configuration names one, else by the localization drive.
Result<Made<EvaluatePlan>> judge(const ReportFlags& flags, const CompileConfig& config,
                                 const CompiledMap& map, const Made<CompilePlan>& compiled) {
  Made<EvaluatePlan> judged{evaluate_plan(config, map), {}};
  const EvaluatePlan& plan = judged.plan;
  provide_map(map, plan, judged.artifacts);
  std::vector<AnyWire> wanted = {plan.evaluation, plan.measured};
  if (config.evaluation.scans.empty()) {
    judged.artifacts.share(plan.measured, compiled.artifacts, compiled.plan.measured);
  } else {
    SIGHTLINE_TRY(provide_drive(plan, cache_directory(flags.run), judged.artifacts));
    wanted.emplace_back(plan.identified);
    if (plan.tracks.is_connected()) wanted.push_back(plan.tracks);
  }
  SIGHTLINE_TRY(run_steps(plan.plan, wanted, flags.run, config, judged.artifacts));
  return judged;
}

// The text beside the map; empty where there is none.
Result<std::string> provenance_beside(const std::string& map) {
  const std::filesystem::path file = map + ".provenance.json";
  std::error_code failure;
  if (!std::filesystem::exists(file, failure)) return std::string();
  return read_text_file(file);
}

// What the files say, kept while the page is made.
struct Loaded {
  CompiledMap map;
  MapSummary summary;
  std::string provenance;
  std::optional<MapDiff> diff;
  std::optional<GateResult> gate;
  std::optional<Weakness> weakness;  // none of a map without sites
  std::optional<EvaluationFigures> evaluation;
};

Result<Weakness> weakness_of(const ReportFlags& flags, const CompiledMap& map) {
  WeaknessOptions options;
  options.most = 5;  // `sightline weak` lists them all
  PassContext ctx;
  ctx.threads = flags.run.threads;
  return find_weakness(ctx, options, map);
}

Result<Loaded> load(const ReportFlags& flags) {
  Loaded loaded;
  SIGHTLINE_ASSIGN(loaded.map, read_map(flags.map_file()));
  SIGHTLINE_ASSIGN(loaded.summary, verify_map(flags.map_file()));
  SIGHTLINE_ASSIGN(loaded.provenance, provenance_beside(flags.map_file()));
  if (!flags.against.empty()) {
    SIGHTLINE_ASSIGN(loaded.diff, diff_maps(flags.against, flags.map_file(), {}));
  }
  if (!loaded.map.sites.sites.empty() && !loaded.map.ranges.promises.empty()) {
    SIGHTLINE_ASSIGN(loaded.weakness, weakness_of(flags, loaded.map));
  }
  SIGHTLINE_ASSIGN(loaded.evaluation, figures_in(flags.evaluation, loaded.map));
  if (!flags.gate.empty()) {
    SIGHTLINE_ASSIGN(loaded.gate, read_gate_result(flags.gate));
  }
  return loaded;
}

ReportSources sources_of(const ReportFlags& flags, const Loaded& loaded) {
  ReportSources sources;
  sources.map = &loaded.map;
  sources.summary = loaded.summary;
  sources.map_file = std::filesystem::path(flags.map_file()).filename();
  sources.provenance = loaded.provenance;
  sources.diff = loaded.diff ? &*loaded.diff : nullptr;
  sources.old_map_file = std::filesystem::path(flags.against).filename();
  sources.weakness = loaded.weakness ? &*loaded.weakness : nullptr;
  sources.gate = loaded.gate ? &*loaded.gate : nullptr;
  sources.figures = loaded.evaluation ? &*loaded.evaluation : nullptr;
  return sources;
}

Result<void> write_page(const ReportFlags& flags, const ReportSources& sources) {
  SIGHTLINE_ASSIGN(const std::string html, report_html(sources));
  SIGHTLINE_TRY(write_file_atomically(flags.output, html, if_exists(flags.is_forced)));
  if (flags.run.is_quiet) return {};
  print_written(flags.output, extent_text(sources.map->sites));
  MapJudgement verdict = judge_map(*sources.map, sources.figures, {});
  verdict.next = concat("open ", flags.output, " in a browser");
  print_text(with_toned_verdict(verdict, to_text(verdict)));
  return {};
}

// The drives add what was measured, and what the compile made on its way to the map.
Result<void> write_page_with_drives(const ReportFlags& flags, const Loaded& loaded) {
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  SIGHTLINE_ASSIGN(const Made<CompilePlan> made, made_on_the_way(flags, config));
  SIGHTLINE_TRY(check_same_map(flags, loaded.map, made));
  SIGHTLINE_ASSIGN(const Made<EvaluatePlan> judged, judge(flags, config, loaded.map, made));
  ReportSources sources = sources_of(flags, loaded);
  sources.measured = &judged.artifacts.get(judged.plan.measured).ranges;
  sources.evaluation = &judged.artifacts.get(judged.plan.evaluation);
  if (judged.artifacts.has(judged.plan.tracks)) {
    sources.tracks = &judged.artifacts.get(judged.plan.tracks);
  }
  // The verdict is by the evaluation file, else by the evaluation drive.
  std::optional<EvaluationFigures> figures;
  if (sources.figures == nullptr && !config.evaluation.scans.empty()) {
    figures = figures_of(loaded.map, *sources.evaluation, sources.tracks);
    SIGHTLINE_ASSIGN(const KnownDrive known,
                     known_drive(loaded.map, config, judged.plan, judged.artifacts));
    figures->origin = known.origin;
    sources.figures = &*figures;
  }
  if (made.plan.trajectory.is_connected()) {
    sources.trajectory = &made.artifacts.get(made.plan.trajectory);
  }
  if (made.plan.points.is_connected()) {
    sources.points = &made.artifacts.get(made.plan.points);
  }
  SIGHTLINE_ASSIGN(const Surface surface, made.artifacts.get(made.plan.surface).whole());
  sources.surface = &surface;
  sources.depth = &made.artifacts.get(made.plan.depth);
  return write_page(flags, sources);
}

// Flags that only a run of passes heeds.
Result<void> check_flags(const ReportFlags& flags) {
  if (!flags.run.stop_after.empty()) {
    return Error{ErrorCode::kBadArgument, "--stop-after: a report needs every pass"};
  }
  if (!flags.is_of_map_alone()) return {};
  if (kind_of_file(flags.run.config_file) == FileKind::kConfiguration) {
    return Error{
        ErrorCode::kBadArgument,
        "a configuration does not name the map to show; add --map FILE, or give only the map",
        flags.run.config_file};
  }
  if (flags.run.overrides.empty()) return {};
  return Error{ErrorCode::kBadArgument,
               "--set: a map alone has no configuration; give that and --map FILE"};
}

Result<void> write_report(const ReportFlags& flags) {
  SIGHTLINE_TRY(check_flags(flags));
  SIGHTLINE_TRY(try_output(flags.output, if_exists(flags.is_forced)));
  if (!has_page_scripts()) {
    std::fputs(
        "warning: this program was built without the page's scripts (npm was missing or could not "
        "install its packages): its pictures are static\n",
        stderr);
  }
  SIGHTLINE_ASSIGN(const Loaded loaded, load(flags));
  if (flags.is_of_map_alone()) return write_page(flags, sources_of(flags, loaded));
  return write_page_with_drives(flags, loaded);
}

}  // namespace

Verb report_verb() {
  const auto flags = std::make_shared<ReportFlags>();
  Verb verb;
  verb.name = "report";
  verb.summary = "Show a map and how well it does as one HTML page that needs no network";
  verb.details =
      "From the map alone the page holds its verdict, the map itself with errors, probabilities "
      "and factors of every site, what is promised, and how the map was made; with --against also "
      "what changed. A configuration and --map add results of its drives: the paper's tables and "
      "figures for this map, its surroundings and depth images, and continuous localization. The "
      "map is then judged by the drive in the section 'evaluation', else by the localization "
      "drive; what compile and evaluate left in the cache is not computed again.";
  verb.examples = {
      "sightline report town.slmap -o town.html",
      "sightline report town.slmap --against released.slmap --gate gate.json -o change.html",
      "sightline report town.yaml --map town.slmap -o town.html    # with results of the drives"};
  verb.positionals = {{.name = "MAP-OR-CONFIG",
                       .help = "The map to show (.slmap); with --map, the YAML configuration that "
                               "made it",
                       .target = &flags->run.config_file}};
  verb.flags = {
      {.names = "--map",
       .value = "FILE",
       .help = "The map to show (.slmap), judged by the configuration's drives",
       .target = &flags->map},
      {.names = "--against",
       .value = "FILE",
       .help = "An older map (.slmap): show the change too",
       .target = &flags->against},
      {.names = "--gate",
       .value = "FILE",
       .help = "What `sightline gate --json` wrote for this map: show its result",
       .target = &flags->gate},
      {.names = "--evaluation",
       .value = "FILE",
       .help = "The JSON of `sightline evaluate` for this map, for the verdict",
       .target = &flags->evaluation},
      ending_in(".html", required_output_flag(flags->output, "The page to write (.html)")),
      force_flag(flags->is_forced)};
  add_flags_of_every_run(verb, flags->run);
  verb.run = [flags] { return exit_status_of(write_report(*flags)); };
  return verb;
}

}  // namespace sightline
