#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/config/inputs.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/picture/charts/calibration_chart.h"
#include "compiler/views/picture/charts/chart.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/factor_report.h"
#include "compiler/views/text/table_rows.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/base/files/atomic_file.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct EvaluateFlags {
  RunFlags run;
  std::string map;
  std::string json;
  std::string csv;
  std::string svg;  // of promised against observed coverage
  bool is_forced = false;
};

Result<CompileConfig> evaluation_config(const EvaluateFlags& flags) {
  SIGHTLINE_ASSIGN(CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  if (config.evaluation.scans.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "evaluation.scans: no drive to judge the map by is named. Name another one there; "
                 "or, where there is one drive, that one again (evaluation.scans, poses and sensor "
                 "as under mapping): the scans that the map did not use then judge it",
                 flags.run.config_file};
  }
  note_known_evaluation(config);
  return config;
}

std::string joined_tables(const std::vector<Table>& all, TableFormat format) {
  std::string text = format == TableFormat::kJson ? "[" : "";
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (format == TableFormat::kJson && i > 0) text += ",\n";
    if (format == TableFormat::kCsv) text += concat("# table: ", all[i].name, "\n");
    text += format_table(all[i], format);
  }
  return format == TableFormat::kJson ? text + "]\n" : text;
}

Result<void> write_files(const EvaluateFlags& flags, const Evaluation& evaluation,
                         const std::vector<Table>& all) {
  const std::pair<std::string, std::string> files[] = {
      {flags.json, joined_tables(all, TableFormat::kJson)},
      {flags.csv, joined_tables(all, TableFormat::kCsv)},
      {flags.svg, chart_file_svg(calibration_chart(evaluation, {}))}};
  for (const auto& [file, text] : files) {
    if (file.empty()) continue;
    SIGHTLINE_TRY(write_file_atomically(file, text, if_exists(flags.is_forced)));
  }
  return {};
}

// Prints what was found and gathers the same as tables.
Result<std::vector<Table>> report(const CompiledMap& map, const EvaluatePlan& made,
                                  const ArtifactSet& artifacts) {
  const Evaluation& evaluation = artifacts.get(made.evaluation);
  const LocalizerProfile& judging = artifacts.get(made.measured).ranges.matching.localizer;
  std::string text =
      concat(judged_by(map.model.localizer, judging), to_text(evaluation, map.sites.frame), "\n");
  std::vector<Table> all = tables(evaluation);
  all.front().facts.emplace_back("judged_by", to_text(judging));
  all.front().facts.emplace_back("ranges_are_for", to_text(map.model.localizer));
  if (artifacts.has(made.tracks)) {
    const DriveTracks& tracks = artifacts.get(made.tracks);
    for (Table& table : tables(tracks)) all.push_back(std::move(table));
    text += to_text(tracks);
  } else {
    text += "Not replayed scan by scan: that is done by this program's own localizers alone\n";
  }
  print_text(text);
  for (Table& table : all) append_world_columns(map.sites.frame, table);
  if (map.factors.factors.empty()) return all;
  SIGHTLINE_ASSIGN(const FactorReport factors,
                   factor_report(map.factors, artifacts.get(made.measured).ranges));
  print_text("\n" + to_text(factors));
  for (Table& table : tables(factors)) all.push_back(std::move(table));
  return all;
}

Result<void> evaluate(const EvaluateFlags& flags) {
  for (const std::string& file : {flags.json, flags.csv, flags.svg}) {
    SIGHTLINE_TRY(try_output(file, if_exists(flags.is_forced)));
  }
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(flags.map));
  SIGHTLINE_ASSIGN(const CompileConfig config, evaluation_config(flags));
  const EvaluatePlan plan = evaluate_plan(config, map);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drive(plan, cache_directory(flags.run), artifacts));
  provide_map(map, plan, artifacts);
  std::vector<AnyWire> wanted = {plan.measured, plan.evaluation};
  if (plan.tracks.is_connected()) wanted.push_back(plan.tracks);
  SIGHTLINE_TRY(run_steps(plan.plan, wanted, flags.run, config, artifacts));
  const AnyWire last = plan.tracks.is_connected() ? plan.tracks.any() : plan.evaluation.any();
  if (!artifacts.has(last)) {
    say_stopped(flags.run, "the map is not judged");
    return {};
  }
  SIGHTLINE_ASSIGN(const std::vector<Table> all, report(map, plan, artifacts));
  return write_files(flags, artifacts.get(plan.evaluation), all);
}

}  // namespace

Verb evaluate_verb() {
  const auto flags = std::make_shared<EvaluateFlags>();
  Verb verb;
  verb.name = "evaluate";
  verb.summary = "Judge a finished map by a drive that it has not seen";
  verb.details =
      "Matches the drive named in the section 'evaluation' against the map at every range, from "
      "the same starts as the compile did, and prints accuracy against time for the map's ranges, "
      "both rules, the best static range and the oracle; by type of street, and on the worst "
      "stretch. Then the drive is replayed as a vehicle localizes: each match starts where the "
      "poses found before predict, at the map's range for the place, and at every range "
      "throughout.";
  verb.examples = {
      "sightline evaluate town.yaml --map town.slmap",
      "sightline evaluate town.yaml --map town.slmap --set evaluation.scans=drive_3/scans \\\n"
      "      --set evaluation.poses=drive_3/poses.tum --json result.json",
      "sightline evaluate town.yaml --map town.slmap --calibration-svg curve.svg",
      "sightline evaluate town.yaml --map town.slmap --set measure-error.localizer=pcl-ndt"};
  verb.flags = {
      {.names = "--map",
       .value = "FILE",
       .help = "The map to judge (.slmap)",
       .target = &flags->map,
       .is_required = true},
      {.names = "--json",
       .value = "FILE",
       .help = "Also write every table to this file, as JSON (schemas/evaluation.schema.json)",
       .target = &flags->json},
      {.names = "--csv",
       .value = "FILE",
       .help = "Also write every table to this file, as CSV",
       .target = &flags->csv},
      {.names = "--calibration-svg",
       .value = "FILE",
       .help = "Also draw promised against observed coverage to this file",
       .target = &flags->svg},
      force_flag(flags->is_forced)};
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(evaluate(*flags)); };
  return verb;
}

}  // namespace sightline
