#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/pipelines.h"
#include "compiler/views/report/report.h"
#include "formats/base/atomic_file.h"
#include "formats/map/diff/diff_maps.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct ReportFlags {
  RunFlags run;
  std::string map;
  std::string against;  // an older map; empty: none
  std::string output;
  bool is_forced = false;
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
  SIGHTLINE_TRY(provide_drives(plan, made.artifacts));
  std::vector<AnyWire> wanted = {plan.trajectory, plan.points, plan.ndt,
                                 plan.surface,    plan.sites,  plan.depth};
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
      flags.map, ""};
}

// Judged by the evaluation drive where the configuration names one, else by the localization drive.
Result<Made<EvaluatePlan>> judge(const ReportFlags& flags, const CompileConfig& config,
                                 const CompiledMap& map, const Made<CompilePlan>& compiled) {
  Made<EvaluatePlan> judged{evaluate_plan(config, map), {}};
  const EvaluatePlan& plan = judged.plan;
  provide_map(map, plan, judged.artifacts);
  std::vector<AnyWire> wanted = {plan.evaluation};
  if (config.evaluation.scans.empty()) {
    judged.artifacts.share(plan.measured, compiled.artifacts, compiled.plan.measured);
  } else {
    SIGHTLINE_TRY(provide_drive(plan, judged.artifacts));
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

Result<void> write_report(const ReportFlags& flags) {
  if (!flags.run.stop_after.empty()) {
    return Error{ErrorCode::kBadArgument, "--stop-after: a report needs every pass", "", ""};
  }
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.map));
  SIGHTLINE_ASSIGN(const MapSummary summary, verify_map(flags.map));
  SIGHTLINE_ASSIGN(const std::string provenance, provenance_beside(flags.map));
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  SIGHTLINE_ASSIGN(const Made<CompilePlan> made, made_on_the_way(flags, config));
  SIGHTLINE_TRY(check_same_map(flags, map, made));
  std::optional<MapDiff> diff;
  if (!flags.against.empty()) {
    SIGHTLINE_ASSIGN(MapDiff found, diff_maps(flags.against, flags.map, {}));
    diff = std::move(found);
  }
  SIGHTLINE_ASSIGN(const Made<EvaluatePlan> judged, judge(flags, config, map, made));
  ReportSources sources;
  sources.map = &map;
  sources.summary = summary;
  sources.map_file = std::filesystem::path(flags.map).filename();
  sources.provenance = provenance;
  sources.measured = &judged.artifacts.get(judged.plan.measured);
  sources.evaluation = &judged.artifacts.get(judged.plan.evaluation);
  if (judged.artifacts.has(judged.plan.tracks)) {
    sources.tracks = &judged.artifacts.get(judged.plan.tracks);
  }
  sources.trajectory = &made.artifacts.get(made.plan.trajectory);
  sources.points = &made.artifacts.get(made.plan.points);
  sources.surface = &made.artifacts.get(made.plan.surface);
  sources.depth = &made.artifacts.get(made.plan.depth);
  sources.diff = diff ? &*diff : nullptr;
  SIGHTLINE_ASSIGN(const std::string html, report_html(sources));
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  return write_file_atomically(flags.output, html, if_exists);
}

}  // namespace

Verb report_verb() {
  const auto flags = std::make_shared<ReportFlags>();
  Verb verb;
  verb.name = "report";
  verb.summary = "Show a map and how well it does as one HTML page that needs no network";
  verb.details =
      "The page holds the paper's tables and figures for this map, the map itself with the depth "
      "image, errors and factors of every site, what was promised and what was measured, how the "
      "map was made and from what. The map is judged by the drive in the section 'evaluation', "
      "else by the localization drive. What compile and evaluate left in the cache is not computed "
      "again.";
  verb.examples = {
      "sightline report town.yaml --map town.slmap -o town.html",
      "sightline report town.yaml --map town.slmap --against released.slmap -o change.html"};
  verb.flags = {{.names = "--map",
                 .value = "FILE",
                 .help = "The map to show (.slmap)",
                 .target = &flags->map,
                 .is_required = true},
                {.names = "--against",
                 .value = "FILE",
                 .help = "An older map (.slmap): show the change too",
                 .target = &flags->against},
                required_output_flag(flags->output, "The page to write (.html)"),
                force_flag(flags->is_forced)};
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(write_report(*flags)); };
  return verb;
}

}  // namespace sightline
