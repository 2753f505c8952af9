#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "compiler/base/atomic_file.h"
#include "compiler/cli/common_flags.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/judged_map.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/run_flags.h"
#include "compiler/report/report.h"
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

// Those of the steps that `wanted` artifacts need and that `artifacts` does not hold already.
std::vector<PassStep> steps_to(std::set<std::string> wanted, const std::vector<PassStep>& steps,
                               const ArtifactSet& artifacts) {
  std::vector<PassStep> needed;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    if (!wanted.contains(step->output) || artifacts.has(step->output)) continue;
    wanted.insert(step->inputs.begin(), step->inputs.end());
    needed.insert(needed.begin(), *step);
  }
  return needed;
}

// What the compile made on its way to the map, from the cache where it can.
Result<ArtifactSet> made_on_the_way(const ReportFlags& flags, const CompileConfig& config) {
  ArtifactSet artifacts;
  const Result<void> provided = provide_drives(config, artifacts);
  if (!provided) return provided.error();
  std::set<std::string> wanted = {
      "mapping/trajectory", "surface-points", "ndt-map", "surface", "sites", "depth-images"};
  if (config.evaluation.scans.empty()) wanted.insert("measured-error");
  const std::vector<PassStep> steps =
      steps_to(wanted, compile_pipeline(config, ModelSource::kGiven), artifacts);
  const Result<std::vector<StepReport>> reports = run_steps(steps, flags.run, config, artifacts);
  if (!reports) return reports.error();
  return artifacts;
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
                            const ArtifactSet& artifacts) {
  const bool is_same = are_same(map.ndt, artifacts.get<NdtMap>("ndt-map")) &&
                       digest_of(map.sites) == digest_of(artifacts.get<Sites>("sites"));
  if (is_same) return {};
  return Error{
      ErrorCode::kMismatchedInputs,
      "the configuration makes other NDs or sites than this map holds; compile it again, or "
      "give the configuration and --set with which it was compiled",
      flags.map, ""};
}

// Judged by the evaluation drive where the configuration names one, else by the localization drive.
Result<ArtifactSet> judge(const ReportFlags& flags, CompileConfig config, const CompiledMap& map,
                          const ArtifactSet& made) {
  ArtifactSet artifacts;
  provide_map(map, artifacts);
  std::set<std::string> wanted = {"evaluation"};
  if (config.evaluation.scans.empty()) {
    artifacts.put("measured-error", made.entry("measured-error"));
  } else {
    const Result<void> provided = provide_evaluation(config, artifacts);
    if (!provided) return provided.error();
    aim_at_map(map, config);
    wanted.insert("drive-tracks");
  }
  const Result<std::vector<StepReport>> reports = run_steps(
      steps_to(wanted, evaluate_pipeline(config), artifacts), flags.run, config, artifacts);
  if (!reports) return reports.error();
  return artifacts;
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
  const Result<CompiledMap> map = read_map(flags.map);
  if (!map) return map.error();
  const Result<MapSummary> summary = verify_map(flags.map);
  if (!summary) return summary.error();
  const Result<std::string> provenance = provenance_beside(flags.map);
  if (!provenance) return provenance.error();
  const Result<CompileConfig> config =
      load_compile_config(flags.run.config_file, flags.run.overrides);
  if (!config) return config.error();
  const Result<ArtifactSet> made = made_on_the_way(flags, *config);
  if (!made) return made.error();
  const Result<void> is_same = check_same_map(flags, *map, *made);
  if (!is_same) return is_same;
  std::optional<MapDiff> diff;
  if (!flags.against.empty()) {
    Result<MapDiff> found = diff_maps(flags.against, flags.map, {});
    if (!found) return found.error();
    diff = std::move(*found);
  }
  const Result<ArtifactSet> judged = judge(flags, *config, *map, *made);
  if (!judged) return judged.error();
  ReportSources sources;
  sources.map = &*map;
  sources.summary = *summary;
  sources.map_file = std::filesystem::path(flags.map).filename();
  sources.provenance = *provenance;
  sources.measured = &judged->get<MeasuredError>("measured-error");
  sources.evaluation = &judged->get<Evaluation>("evaluation");
  if (judged->has("drive-tracks")) sources.tracks = &judged->get<DriveTracks>("drive-tracks");
  sources.trajectory = &made->get<Trajectory>("mapping/trajectory");
  sources.points = &made->get<SurfacePoints>("surface-points");
  sources.surface = &made->get<Surface>("surface");
  sources.depth = &made->get<DepthImages>("depth-images");
  sources.diff = diff ? &*diff : nullptr;
  const Result<std::string> html = report_html(sources);
  if (!html) return html.error();
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  return write_file_atomically(flags.output, *html, if_exists);
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
