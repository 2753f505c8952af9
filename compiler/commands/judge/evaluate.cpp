#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/result_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/verdict_output.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/known_drive.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/picture/charts/calibration_chart.h"
#include "compiler/views/picture/charts/chart.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/factor_report.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/text/table_rows.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/base/files/atomic_file.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

const std::vector<std::string> kFormats = {"text", "json", "csv"};

struct EvaluateFlags {
  RunFlags run;
  std::string map;
  std::string json;
  std::string csv;
  std::string svg;  // of promised against observed coverage
  bool prints_tables = false;
  bool allows_known_drive = false;
  ResultFlags result;  // whose is_forced is that of every file
};

// Where no drive is named, that of a map that every second scan of one drive made.
Result<CompileConfig> evaluation_config(const EvaluateFlags& flags, const CompiledMap& map) {
  SIGHTLINE_ASSIGN(CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  if (!config.evaluation.scans.empty()) return config;
  if (has_other_scans(map, config)) {
    config.evaluation = config.mapping;
    print_note(
        "no drive is named under evaluation: the scans of the mapping drive that did not make the "
        "map judge it; another drive is a better test");
    return config;
  }
  return Error{ErrorCode::kMissingKey,
               "evaluation.scans: no drive to judge the map by is named; name one that did not "
               "make the map",
               flags.run.config_file};
}

// With the map that the drive was compared with.
Error naming_map(Error error, const EvaluateFlags& flags) {
  if (error.code == ErrorCode::kNoOverlap) error.message += concat("; map ", flags.map);
  return error;
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
    SIGHTLINE_TRY(write_file_atomically(file, text, if_exists(flags.result.is_forced)));
    if (flags.result.format == "text") print_written(file);
  }
  return {};
}

// What was found, as tables for people and for programs.
struct Evaluated {
  std::string text;
  std::vector<Table> tables;
};

// The map that was judged, and by whose evidence.
struct Judged {
  CompiledMap map;
  std::string root_digest;
  KnownDrive drive = {};
};

Result<Evaluated> found_in(const Judged& judged, const EvaluatePlan& made,
                           const ArtifactSet& artifacts) {
  const CompiledMap& map = judged.map;
  const Evaluation& evaluation = artifacts.get(made.evaluation);
  const LocalizerProfile& judging = artifacts.get(made.measured).ranges.matching.localizer;
  Evaluated found = {
      concat(judged_by(map.model.localizer, judging), to_text(evaluation, map.sites.frame), "\n"),
      tables(evaluation)};
  Table& head = found.tables.front();
  head.facts.emplace_back("drive_role", std::string(name_of(judged.drive.origin)));
  head.facts.emplace_back("drive_sha256",
                          to_hex(artifacts.get(made.identified).cards.front().digest));
  head.facts.emplace_back("map_id", map.map_id);
  head.facts.emplace_back("root_digest", judged.root_digest);
  found.tables.front().facts.emplace_back("judged_by", to_text(judging));
  found.tables.front().facts.emplace_back("ranges_are_for", to_text(map.model.localizer));
  if (artifacts.has(made.tracks)) {
    const DriveTracks& tracks = artifacts.get(made.tracks);
    for (Table& table : tables(tracks)) found.tables.push_back(std::move(table));
    found.text += to_text(tracks);
  } else {
    found.text +=
        "Not replayed scan by scan: that is done by this program's own localizers alone\n";
  }
  for (Table& table : found.tables) append_world_columns(map.sites.frame, table);
  if (map.factors.factors.empty()) return found;
  SIGHTLINE_ASSIGN(const FactorReport factors,
                   factor_report(map.factors, artifacts.get(made.measured).ranges));
  found.text += "\n" + to_text(factors);
  for (Table& table : tables(factors)) found.tables.push_back(std::move(table));
  return found;
}

// The verdict without the promise, which the map has had before, and the answers beside the best
// constant one: at most 12 lines.
std::string answers_text(const CompiledMap& map, const EvaluatePlan& made,
                         const ArtifactSet& artifacts, const EvaluationFigures& figures,
                         MapJudgement judgement) {
  const LocalizerProfile& judging = artifacts.get(made.measured).ranges.matching.localizer;
  judgement.promise.clear();
  std::string text = to_text(judgement);
  if (judging != map.model.localizer) {
    text += concat("Judged by ", localizer_title(judging), "; the map is for ",
                   localizer_title(map.model.localizer), "\n");
  }
  return text + answers_table(figures, judgement);
}

Result<void> put_found(const EvaluateFlags& flags, const Judged& judged, const EvaluatePlan& made,
                       const ArtifactSet& artifacts) {
  const CompiledMap& map = judged.map;
  SIGHTLINE_ASSIGN(const Evaluated found, found_in(judged, made, artifacts));
  SIGHTLINE_TRY(write_files(flags, artifacts.get(made.evaluation), found.tables));
  const std::string format = flags.result.chosen_format(kFormats);
  const bool is_text = format == "text";
  if (!is_text) {
    const TableFormat form = format == "json" ? TableFormat::kJson : TableFormat::kCsv;
    SIGHTLINE_TRY(put_result(flags.result, joined_tables(found.tables, form)));
    if (flags.result.output.empty()) return {};
  }
  const DriveTracks* const tracks =
      artifacts.has(made.tracks) ? &artifacts.get(made.tracks) : nullptr;
  EvaluationFigures figures = figures_of(map, artifacts.get(made.evaluation), tracks);
  figures.origin = judged.drive.origin;
  const MapJudgement judgement =
      judge_map(map, &figures, {.map = flags.map, .config = flags.run.config_file});
  std::string text = answers_text(map, made, artifacts, figures, judgement);
  if (flags.prints_tables) text += "\n" + found.text;
  if (is_text && !flags.result.output.empty()) return put_result(flags.result, text);
  if (!flags.run.is_quiet) print_text(with_toned_verdict(judgement, text));
  return {};
}

// Before the drive is matched, which takes minutes. False: --stop-after ended the run.
Result<bool> identify_drive(const EvaluateFlags& flags, const CompileConfig& config,
                            const EvaluatePlan& plan, ArtifactSet& artifacts) {
  RunFlags first = flags.run;
  first.time_passes = first.explain = false;
  SIGHTLINE_TRY(run_steps(plan.plan, {plan.identified}, first, config, artifacts));
  return artifacts.has(plan.identified);
}

Result<void> refuse_known(const EvaluateFlags& flags, const KnownDrive& drive) {
  if (drive.origin == DriveOrigin::kUnknown) {
    print_note(concat("origin unknown: ", drive.why,
                      ", so the drive may be one of these. Compile the map again with this program "
                      "(`sightline compile CONFIG -o MAP --force`; a given model: `sightline "
                      "train` first)"));
  }
  if (drive.origin != DriveOrigin::kKnown) return {};
  if (flags.allows_known_drive) {
    print_note(
        concat("known drive: ", drive.why, ": the results are better than on another drive"));
    return {};
  }
  return Error{ErrorCode::kKnownDrive,
               concat("evaluation.scans: ", drive.why,
                      ", so the results would be better than on another drive. Name another drive, "
                      "or add --allow-known-drive: every output is then marked"),
               flags.run.config_file};
}

Result<void> evaluate(const EvaluateFlags& flags) {
  for (const std::string& file : {flags.json, flags.csv, flags.svg}) {
    SIGHTLINE_TRY(try_output(file, if_exists(flags.result.is_forced)));
  }
  SIGHTLINE_TRY(try_result(flags.result));
  SIGHTLINE_ASSIGN(const MapSummary summary, verify_map(flags.map));
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(flags.map));
  Judged judged{std::move(map), to_hex(summary.root_digest)};
  SIGHTLINE_ASSIGN(CompileConfig config, evaluation_config(flags, judged.map));
  const EvaluatePlan plan = evaluate_plan(config, judged.map);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drive(plan, cache_directory(flags.run), artifacts));
  provide_map(judged.map, plan, artifacts);
  SIGHTLINE_ASSIGN(const bool is_identified, identify_drive(flags, config, plan, artifacts));
  if (!is_identified) {
    say_stopped(flags.run, "the map is not judged");
    return {};
  }
  SIGHTLINE_ASSIGN(judged.drive, known_drive(judged.map, config, plan, artifacts));
  SIGHTLINE_TRY(refuse_known(flags, judged.drive));
  config.notes.clear();  // they were shown before the drive was identified
  std::vector<AnyWire> wanted = {plan.measured, plan.evaluation};
  if (plan.tracks.is_connected()) wanted.push_back(plan.tracks);
  const Result<std::vector<StepReport>> run =
      run_steps(plan.plan, wanted, flags.run, config, artifacts);
  if (!run) return naming_map(run.error(), flags);
  const AnyWire last = plan.tracks.is_connected() ? plan.tracks.any() : plan.evaluation.any();
  if (!artifacts.has(last)) {
    say_stopped(flags.run, "the map is not judged");
    return {};
  }
  return put_found(flags, judged, plan, artifacts);
}

}  // namespace

Verb evaluate_verb() {
  const auto flags = std::make_shared<EvaluateFlags>();
  Verb verb;
  verb.name = "evaluate";
  verb.summary = "Judge a finished map by a drive that it has not seen";
  verb.details =
      "Matches the drive named in the section 'evaluation' against the map at every range, from "
      "the same starts as the compile did. Where none is named and every second scan of one drive "
      "made the map, the other scans judge it, and every output is marked. Then replays the drive "
      "as a vehicle localizes: each match "
      "starts where the poses found before predict, by the map's plan, looks and ranges, and by "
      "each look and range taken everywhere. Prints the verdict on the map, and share within the "
      "limit, lost tracks and time beside the best fixed choice. With --tables it also prints "
      "tables as in the paper of Javanmardi, Javanmardi and Kamijo (see README): every rule, types "
      "of street, the worst stretch, calibration.";
  verb.examples = {
      "sightline evaluate town.yaml --map town.slmap",
      "sightline evaluate town.yaml --map town.slmap --set evaluation.scans=drive_3/scans \\\n"
      "      --set evaluation.poses=drive_3/poses.tum -o evaluation.json",
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
      {.names = "--tables", .help = "Also print every table", .target = &flags->prints_tables},
      {.names = "--allow-known-drive",
       .help = "Also judge by a drive that made the map, whose errors were measured in it or that "
               "trained its model; every output is marked, and `gate` does not count it",
       .target = &flags->allows_known_drive}};
  add_result_flags(verb, flags->result, kFormats,
                   "json as schemas/evaluation.schema.json describes it");
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(evaluate(*flags)); };
  return verb;
}

}  // namespace sightline
