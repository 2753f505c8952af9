#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provenance.h"
#include "compiler/driver/run_flags.h"
#include "formats/evaluation.h"
#include "formats/map/map_writer.h"
#include "formats/sharpness.h"
#include "passes/factors/factor_report.h"

namespace sightline {
namespace {

struct CompileFlags {
  RunFlags run;
  std::string output;
  std::string model;  // empty: trained on this compile's own drive
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

Result<void> write_outputs(const CompileFlags& flags, const CompileConfig& config,
                           const ArtifactSet& artifacts, const std::vector<StepReport>& reports) {
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  const std::vector<std::byte> map = encode_map(artifacts.get<CompiledMap>("compiled-map"));
  const Result<void> written = write_file_atomically(flags.output, map, if_exists);
  if (!written) return written;
  // A stale provenance beside a new map would be worse than replacing one.
  return write_file_atomically(flags.output + ".provenance.json",
                               provenance_json(config, command_line(), artifacts, reports),
                               IfExists::kReplace);
}

Result<void> compile(const CompileFlags& flags) {
  const Result<void> free = check_output(flags);
  if (!free) return free;
  const Result<CompileConfig> config =
      load_compile_config(flags.run.config_file, flags.run.overrides);
  if (!config) return config.error();
  ArtifactSet artifacts;
  const Result<void> provided = provide_drives(*config, artifacts);
  if (!provided) return provided;
  ModelSource source = ModelSource::kTrained;
  if (!flags.model.empty()) {
    const Result<void> given = provide_model(flags.model, artifacts);
    if (!given) return given;
    source = ModelSource::kGiven;
  }
  const Result<std::vector<StepReport>> reports =
      run_steps(compile_pipeline(*config, source), flags.run, *config, artifacts);
  if (!reports) return reports.error();
  if (!artifacts.has("compiled-map")) return {};  // --stop-after
  const Result<void> written = write_outputs(flags, *config, artifacts, *reports);
  if (!written) return written;
  if (!flags.run.is_quiet) {
    std::fputs(to_text(artifacts.get<Evaluation>("evaluation")).c_str(), stdout);
    std::fputs(("\n" + to_text(artifacts.get<Sharpness>("sharpness")) + "\n").c_str(), stdout);
    const Result<FactorReport> report = factor_report(
        artifacts.get<FactorTable>("factor-table"), artifacts.get<MeasuredError>("measured-error"));
    if (!report) return report.error();
    std::fputs(("\n" + to_text(*report)).c_str(), stdout);
  }
  return {};
}

}  // namespace

void add_compile_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<CompileFlags>();
  CLI::App* command = app.add_subcommand("compile", "Compile drives into an annotated map");
  command->footer(
      "The tables on stdout are judged on the localization drive by models that never saw the "
      "place.\nFinished passes are cached: after an interruption or a change only what is affected "
      "runs again.\n\n"
      "Examples:\n"
      "  sightline compile town.yaml -o town.slmap\n"
      "  sightline compile street.yaml -o street.slmap --model city.slmodel --risk 0.1\n"
      "  sightline compile city.yaml -o city.slmap --strict\n"
      "  sightline compile town.yaml -o town.slmap --set build-ndt.cell_m=1.0 --explain\n"
      "  sightline compile town.yaml --stop-after build-ndt --print-after build-ndt");
  add_run_flags(*command, flags->run);
  command->add_option("-o,--output", flags->output, "The map file to write (.slmap)");
  command->add_option(
      "--model", flags->model,
      "Take the error model of this file (sightline train) or map (.slmap) instead of "
      "training one; what the localization drive measures is told to it as history");
  command->add_option_function<std::string>(
      "--risk",
      [flags](const std::string& alpha) {
        flags->run.overrides.push_back("choose-ranges.alpha=" + alpha);
      },
      "Share of the route that may miss its limit on the next drive (choose-ranges.alpha)");
  command->add_flag_callback(
      "--strict",
      [flags] { flags->run.overrides.push_back("choose-ranges.risk_control=learn-then-test"); },
      "Promise it with confidence 1 - choose-ranges.delta rather than on average; needs more "
      "route");
  command->add_flag("--force", flags->is_forced, "Replace the output if it exists");
  command->callback([flags, &status] {
    const Result<void> compiled = compile(*flags);
    status = compiled ? 0 : report_error(compiled.error());
  });
}

}  // namespace sightline
