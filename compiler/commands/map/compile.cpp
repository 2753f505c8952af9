#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/config/input_files.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provenance.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/factor_report.h"
#include "formats/base/atomic_file.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/map_writer.h"
#include "formats/surroundings/sharpness.h"

namespace sightline {
namespace {

struct CompileFlags {
  RunFlags run;
  std::string output;
  std::string model;    // empty: trained on this compile's own drive
  std::string depfile;  // empty: none
  bool lists_inputs = false;
  bool is_forced = false;
};

// Before hours of work rather than after them.
Result<void> check_output(const CompileFlags& flags) {
  if (flags.output.empty() && flags.run.stop_after.empty()) {
    return Error{ErrorCode::kBadArgument, "-o is required: which map file to write", "", ""};
  }
  std::error_code failure;
  if (!flags.is_forced && std::filesystem::exists(flags.output, failure)) {
    return Error{ErrorCode::kOutputExists, "the output exists already; --force replaces it",
                 flags.output, ""};
  }
  return {};
}

Result<void> write_outputs(const CompileFlags& flags, const CompiledMap& map,
                           const std::string& provenance) {
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  SIGHTLINE_TRY(write_file_atomically(flags.output, encode_map(map), if_exists));
  // A stale provenance beside a new map would be worse than replacing one.
  return write_file_atomically(flags.output + ".provenance.json", provenance, IfExists::kReplace);
}

// What the compile found, as text.
Result<std::string> summary_text(const CompilePlan& made, const ArtifactSet& artifacts) {
  const LocalizerProfile& foretold = artifacts.get(made.map).model.localizer;
  const LocalizerProfile& measured = artifacts.get(made.measured).matching.localizer;
  std::string text = judged_by(foretold, measured) + to_text(artifacts.get(made.evaluation)) +
                     "\nWhat the map promises, to a vehicle that localizes with " +
                     localizer_title(foretold) + "\n";
  for (const LimitPromise& promise : artifacts.get(made.ranges).promises) {
    text += promise.statement + "\n";
  }
  text += "\n" + to_text(artifacts.get(made.sharpness)) + "\n";
  SIGHTLINE_ASSIGN(const FactorReport report,
                   factor_report(artifacts.get(made.factors), artifacts.get(made.measured)));
  return text + "\n" + to_text(report);
}

// Files, one a line.
Result<void> list_inputs(const CompileFlags& flags, const CompileConfig& config) {
  SIGHTLINE_ASSIGN(const InputFiles inputs,
                   input_files(config, flags.run.config_file, flags.model));
  for (const std::filesystem::path& file : inputs.files) std::printf("%s\n", file.c_str());
  return {};
}

// Before the compile: what changes meanwhile is then newer than its map.
Result<void> write_depfile(const CompileFlags& flags, const CompileConfig& config) {
  if (flags.depfile.empty()) return {};
  if (flags.output.empty()) {
    return Error{ErrorCode::kBadArgument, "--depfile needs -o: what the files are inputs of", "",
                 ""};
  }
  SIGHTLINE_ASSIGN(const InputFiles inputs,
                   input_files(config, flags.run.config_file, flags.model));
  return write_file_atomically(flags.depfile, depfile_text(flags.output, inputs),
                               IfExists::kReplace);
}

Result<void> run_compile(const CompileFlags& flags) {
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  if (flags.lists_inputs) return list_inputs(flags, config);
  SIGHTLINE_TRY(check_output(flags));
  SIGHTLINE_TRY(write_depfile(flags, config));
  const bool is_given = !flags.model.empty();
  const CompilePlan compile =
      compile_plan(config, is_given ? ModelSource::kGiven : ModelSource::kTrained);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, artifacts));
  if (is_given) {
    SIGHTLINE_ASSIGN(ErrorModel model, read_model(flags.model));
    artifacts.provide(compile.given_model, std::move(model));
  }
  SIGHTLINE_ASSIGN(const std::vector<StepReport> reports,
                   run_steps(compile.plan, {}, flags.run, config, artifacts));
  if (!artifacts.has(compile.map)) return {};  // --stop-after
  const Result<void> written =
      write_outputs(flags, artifacts.get(compile.map),
                    provenance_json(config, command_line(), artifacts.get(compile.cards), reports));
  if (!written || flags.run.is_quiet) return written;
  SIGHTLINE_ASSIGN(const std::string summary, summary_text(compile, artifacts));
  std::fputs(summary.c_str(), stdout);
  return {};
}

Setter risk_setter(CompileFlags& flags) {
  return [&flags](const std::string& alpha) -> Result<void> {
    flags.run.overrides.push_back("choose-ranges.alpha=" + alpha);
    return {};
  };
}

Setter strict_setter(CompileFlags& flags) {
  return [&flags](const std::string& /*value*/) -> Result<void> {
    flags.run.overrides.emplace_back("choose-ranges.risk_control=learn-then-test");
    return {};
  };
}

}  // namespace

Verb compile_verb() {
  const auto flags = std::make_shared<CompileFlags>();
  Verb verb;
  verb.name = "compile";
  verb.summary = "Compile drives into an annotated map";
  verb.details =
      "The tables on stdout are judged on the localization drive by models that never saw the "
      "place. Finished passes are cached: after an interruption or a change only what is affected "
      "runs again.\n\n"
      "Ranges and probabilities are for the localizer whose errors were measured: one of this "
      "program's own, PCL's NDT (measure-error.localizer), or any other whose errors the section "
      "import-errors names, as CSV: a line \"scan,look,start,error\", then one error a line.";
  verb.examples = {
      "sightline compile town.yaml -o town.slmap",
      "sightline compile street.yaml -o street.slmap --model city.slmodel --risk 0.1",
      "sightline compile city.yaml -o city.slmap --strict",
      "sightline compile town.yaml -o town.slmap --set measure-error.localizer=pcl-ndt",
      ("sightline compile town.yaml -o town.slmap --set import-errors.file=my_errors.csv \\\n"
       "      --set import-errors.localizer=my-ndt"),
      "sightline compile town.yaml -o town.slmap --set build-ndt.cell_m=1.0 --explain",
      "sightline compile town.yaml --stop-after build-ndt --print-after build-ndt",
      "sightline compile town.yaml -o town.slmap --force --depfile town.d --json-progress"};
  verb.flags = {
      output_flag(flags->output, "The map to write (.slmap)"),
      force_flag(flags->is_forced),
      {.names = "--model",
       .value = "FILE",
       .help = "Take the error model of this file (.slmodel, of `sightline train`) or map (.slmap) "
               "instead of training one; what the localization drive measures is given to it as "
               "history",
       .target = &flags->model},
      {.names = "--risk",
       .value = "SHARE",
       .help =
           "Share of the route that may miss its limit on the next drive; 0: the strictest that is "
           "earned (choose-ranges.alpha)",
       .target = risk_setter(*flags)},
      {.names = "--strict",
       .help = "Promise it with confidence 1 - choose-ranges.delta rather than on average; needs "
               "more route",
       .target = strict_setter(*flags)},
      {.names = "--list-inputs",
       .help = "Print every file that this compile would read, one a line, and end",
       .target = &flags->lists_inputs},
      {.names = "--depfile",
       .value = "FILE",
       .help = "Also write what the map depends on to this file, as Make and Ninja read it",
       .target = &flags->depfile}};
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(run_compile(*flags)); };
  return verb;
}

}  // namespace sightline
