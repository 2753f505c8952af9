#include "compiler/commands/map/compile_to_map.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/verdict_output.h"
#include "compiler/config/expected_cost.h"
#include "compiler/config/inputs.h"
#include "compiler/driver/model_source.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/plans.h"
#include "compiler/driver/provenance.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/pipeline/process_cost.h"
#include "compiler/pipeline/runner.h"
#include "compiler/pipeline/schedule.h"
#include "compiler/store/cache.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/text/factor_report.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/printable.h"
#include "formats/base/statistics.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/map_file.h"
#include "formats/map/map_reader.h"
#include "formats/surroundings/sharpness.h"
#include "passes/rays/site_blocks.h"

namespace sightline {
namespace {

std::string provenance_beside(const std::string& map) {
  return map.empty() ? "" : map + ".provenance.json";
}

// Before hours of work rather than after them.
Result<void> check_outputs(const CompileFlags& flags) {
  if (flags.output.empty() && flags.run.stop_after.empty() && !flags.is_dry) {
    return Error{ErrorCode::kBadArgument, "-o is required: which map file to write"};
  }
  SIGHTLINE_TRY(try_output(flags.depfile, IfExists::kReplace));
  SIGHTLINE_TRY(try_output(flags.poses, if_exists(flags.is_forced)));
  return try_outputs_of_map(flags.output, if_exists(flags.is_forced));
}

std::filesystem::path poses_beside(const std::string& map) {
  return std::filesystem::path(map).replace_extension(".slposes");
}

Result<void> write_outputs(const std::string& output, IfExists if_exists, const MapFile& map,
                           const std::string& provenance) {
  const WriteInto write = [&](const ByteSink& file) { return map.bytes.visit(file); };
  SIGHTLINE_TRY(write_file_atomically(output, write, if_exists));
  // A stale provenance beside a new map would be worse than replacing one.
  return write_file_atomically(provenance_beside(output), provenance, IfExists::kReplace);
}

Result<void> write_poses(const std::filesystem::path& file, IfExists if_exists,
                         const CompilePlan& compile, const ArtifactSet& artifacts) {
  return write_file_atomically(file, to_bytes(artifacts.get(compile.released)), if_exists);
}

// What the compile found on the localization drive.
Result<std::string> tables_text(const CompilePlan& made, const ArtifactSet& artifacts) {
  const LocalizerProfile& of_map = artifacts.get(made.map).predicted_localizer;
  const LocalizerProfile& measured = artifacts.get(made.measured).ranges.matching.localizer;
  const bool is_simulated =
      artifacts.get(made.measured).ranges.reference == ErrorReference::kSimulated;
  std::string text = is_simulated ? "Simulated: no drive was here. The figures are of scans "
                                    "that were simulated in the map itself.\n\n"
                                  : "";
  text += concat(judged_by(of_map, measured),
                 to_text(artifacts.get(made.evaluation), artifacts.get(made.sites).frame),
                 "\nPromises of the map, for a vehicle that localizes with ",
                 localizer_title(of_map), "\n");
  for (const LimitPromise& promise : artifacts.get(made.ranges).ranges.promises) {
    text += promise.statement + "\n";
  }
  if (made.sharpness.is_connected()) {
    text += concat("\n", to_text(artifacts.get(made.sharpness)), "\n");
  }
  SIGHTLINE_ASSIGN(const FactorReport report, factor_report(artifacts.get(made.factors).ranges,
                                                            artifacts.get(made.measured).ranges));
  return concat(text, "\n", to_text(report));
}

// Files, one a line.
Result<void> list_inputs(const CompileFlags& flags, const CompileConfig& config,
                         const ChosenModel& model) {
  SIGHTLINE_ASSIGN(const InputFiles inputs, input_files(config, flags.run.config_file, model.file));
  for (const std::filesystem::path& file : inputs.files) print_data(one_line(file.string()) + "\n");
  return {};
}

// Before the compile: what changes meanwhile is then newer than its map.
Result<void> write_depfile(const CompileFlags& flags, const CompileConfig& config,
                           const ChosenModel& model) {
  if (flags.depfile.empty()) return {};
  if (flags.output.empty()) {
    return Error{ErrorCode::kBadArgument, "--depfile needs -o: what the files are inputs of"};
  }
  SIGHTLINE_ASSIGN(const InputFiles inputs, input_files(config, flags.run.config_file, model.file));
  return write_file_atomically(flags.depfile, depfile_text(flags.output, inputs),
                               IfExists::kReplace);
}

constexpr std::array<std::string_view, 2> kDearPasses = {"compute-factors", "simulate-error"};
// All other passes, for each place.
constexpr double kOthers_s = 0.0005;
constexpr std::size_t kBlocks = 6;
constexpr std::size_t kFew = 4;  // of a block
constexpr std::size_t kMany = 32;

// Those that hold sites which lie evenly among all, each once.
std::vector<SiteBlock> some_blocks(const Sites& sites) {
  std::vector<SiteBlock> some;
  for (SiteBlock& block : blocks_of_sites(sites)) {
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const std::size_t site = (2 * i + 1) * sites.sites.size() / (2 * kBlocks);
      if (!std::ranges::binary_search(block.sites, site)) continue;
      some.push_back(std::move(block));
      break;
    }
  }
  return some;
}

// At most so many of each block, evenly among its own.
Sites some_sites(const Sites& all, std::span<const SiteBlock> blocks, std::size_t most) {
  std::vector<std::size_t> chosen;
  for (const SiteBlock& block : blocks) {
    for (const std::size_t i : evenly(block.sites.size(), most)) chosen.push_back(block.sites[i]);
  }
  std::ranges::sort(chosen);
  Sites some;
  some.frame = all.frame;
  some.spacing_m = all.spacing_m;
  for (const std::size_t site : chosen) some.sites.push_back(all.sites[site]);
  return some;
}

// Seconds of one core that the dear passes take for these places.
Result<double> cpu_of(const CompilePlan& compile, const RunOptions& options,
                      const ArtifactSet& artifacts, const Sites& some) {
  const std::shared_ptr<const void> sites = std::make_shared<const Sites>(some);
  double cpu_s = 0.0;
  for (const PassStep& step : compile.plan.steps()) {
    if (std::ranges::find(kDearPasses, step.name) == kDearPasses.end()) continue;
    std::vector<std::shared_ptr<const void>> inputs;
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      const AnyWire input{step.inputs[i]};
      ArtifactSet::Entry entry = artifacts.entry(input);
      if (input == compile.sites.any()) entry.value = sites;
      SIGHTLINE_ASSIGN(std::shared_ptr<const void> taken, in_form(entry, *step.input_types[i]));
      inputs.push_back(std::move(taken));
    }
    PassContext ctx;
    ctx.seed = options.seed;
    const double begin_s = process_cpu_s();
    SIGHTLINE_TRY(step.run(ctx, inputs));
    cpu_s += process_cpu_s() - begin_s;
  }
  return cpu_s;
}

// Whether all that is dear of what is tried on is there, and what it is for is not.
bool can_try(const CompilePlan& compile, const RunOptions& options, const ArtifactSet& artifacts) {
  if (!compile.simulated.is_connected()) return false;
  const auto is_there = [&](AnyWire wire) {
    const std::vector<PlannedRun> runs = planned_runs(compile.plan, {wire}, options, artifacts);
    return !runs.empty() && runs.back().is_in_cache;
  };
  return is_there(compile.sites) && is_there(compile.surface) && !is_there(compile.simulated);
}

// What the places of a finished map will cost, estimated by trying some of them: a few of several
// blocks go through the passes in which nearly all of the time is spent, with their options, on one
// thread, and nothing of it is kept. So machine, sensor, looks and scenery are those of the run.
// Nothing where surface or places are not in the cache yet, or what they are for is; NDs are made,
// and kept, where they are not. Inputs of the plan must be in `artifacts`. Errors: those of the
// passes and the cache.
// What a pass takes for some places is a part for the whole map, one for each block of places, and
// one for each place. Three trials tell them apart: few places of one block, few of each of several
// blocks, many of these.
Result<std::optional<ExpectedPlaces>> try_places(const CompilePlan& compile,
                                                 const RunOptions& options, ArtifactSet artifacts) {
  if (!can_try(compile, options, artifacts)) return std::optional<ExpectedPlaces>();
  std::vector<StepReport> reports;
  SIGHTLINE_TRY(run_plan(compile.plan, {compile.ndt, compile.surface, compile.sites}, options, {},
                         artifacts, reports));
  const Sites& sites = artifacts.get(compile.sites);
  const std::vector<SiteBlock> blocks = some_blocks(sites);
  const Sites few_of_one = some_sites(sites, std::span(blocks).first(1), kFew);
  const Sites few = some_sites(sites, blocks, kFew);
  const Sites many = some_sites(sites, blocks, kMany);
  SIGHTLINE_ASSIGN(const double one_s, cpu_of(compile, options, artifacts, few_of_one));
  SIGHTLINE_ASSIGN(const double few_s, cpu_of(compile, options, artifacts, few));
  SIGHTLINE_ASSIGN(const double many_s, cpu_of(compile, options, artifacts, many));
  const auto count_of = [](const Sites& of) { return static_cast<double>(of.sites.size()); };
  const double more = count_of(many) - count_of(few);
  const double place_s = more > 0.0 ? std::max(0.0, (many_s - few_s) / more) : 0.0;
  const double more_blocks = static_cast<double>(blocks.size()) - 1.0;
  const double of_blocks_s = few_s - one_s - place_s * (count_of(few) - count_of(few_of_one));
  const double block_s = more_blocks > 0.0 ? std::max(0.0, of_blocks_s / more_blocks) : 0.0;
  ExpectedPlaces places{sites.sites.size(), many.sites.size(), many_s};
  places.cpu_s += (place_s + kOthers_s) * (count_of(sites) - count_of(many));
  places.cpu_s += block_s * static_cast<double>(blocks_of_sites(sites).size() - blocks.size());
  return std::optional(places);
}

// What the compile would take.
Result<void> estimate_cost(const CompileFlags& flags, const CompileConfig& config,
                           const CompilePlan& compile, const ArtifactSet& artifacts) {
  const RunOptions options = run_options(flags.run, config);
  const ArtifactCache cache = ArtifactCache::to_look_at(options.cache_directory);
  if (const Result<void> writable = cache.check_writable(); !writable) {
    print_warning(cannot_store_text(writable.error()));
  }
  ExpectedCost cost =
      expected_cost(compile.plan, reported_artifacts(compile), options, config, artifacts);
  SIGHTLINE_ASSIGN(cost.places, try_places(compile, options, artifacts));
  if (flags.summary.format == "json") {
    print_data(to_json(cost));
  } else {
    print_text(to_text(cost, options.cache_directory));
  }
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

Result<void> compile_to_map(const CompileFlags& flags, const CompileConfig& config) {
  SIGHTLINE_ASSIGN(const ChosenModel model, choose_model(config, flags.model));
  if (flags.lists_inputs) return list_inputs(flags, config, model);
  SIGHTLINE_TRY(check_outputs(flags));
  if (!flags.is_dry) {
    SIGHTLINE_TRY(write_depfile(flags, config, model));
  }
  const bool is_stderr_json = flags.run.json_progress == STDERR_FILENO;
  if (!model.why_own.empty() && !is_stderr_json) print_note(model.why_own);
  const CompilePlan compile = compile_plan(config, model.source());
  SIGHTLINE_TRY(try_poses_output(flags.output, if_exists(flags.is_forced), compile));
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(flags.run), artifacts));
  SIGHTLINE_TRY(provide_model(compile, model.file, artifacts));
  if (flags.is_dry) return estimate_cost(flags, config, compile, artifacts);
  std::vector<AnyWire> wanted = reported_artifacts(compile);
  if (!flags.poses.empty()) wanted.push_back(compile.released);
  SIGHTLINE_ASSIGN(const std::vector<StepReport> reports,
                   run_steps(compile.plan, wanted, flags.run, config, artifacts));
  if (flags.output.empty() || !artifacts.has(compile.map)) {
    say_stopped(flags.run, "no map is written");
    return {};
  }
  if (!flags.poses.empty()) {
    SIGHTLINE_TRY(write_poses(flags.poses, if_exists(flags.is_forced), compile, artifacts));
  }
  const Result<void> written =
      write_compiled(flags.output, if_exists(flags.is_forced), config, compile, artifacts, reports);
  if (!written || flags.run.is_quiet) return written;
  VerdictFiles files = {.map = flags.output};
  if (!flags.run.config_file.empty()) {
    files.config = flags.run.config_file;
    files.names_evaluation = !config.evaluation.scans.empty();
  }
  return print_summary(flags.summary, files, compile, artifacts);
}

Result<void> try_outputs_of_map(const std::string& output, IfExists if_exists) {
  SIGHTLINE_TRY(try_output(output, if_exists));
  return try_output(provenance_beside(output), IfExists::kReplace);
}

Result<void> try_poses_output(const std::string& output, IfExists if_exists,
                              const CompilePlan& compile) {
  if (output.empty() || !compile.ships_poses) return {};
  return try_output(poses_beside(output).string(), if_exists);
}

Result<void> write_compiled(const std::string& output, IfExists if_exists,
                            const CompileConfig& config, const CompilePlan& compile,
                            const ArtifactSet& artifacts, const std::vector<StepReport>& reports) {
  const std::string provenance =
      provenance_json(config, command_line(), artifacts.get(compile.cards), reports);
  SIGHTLINE_TRY(write_outputs(output, if_exists, artifacts.get(compile.map), provenance));
  if (!compile.ships_poses) return {};
  return write_poses(poses_beside(output), if_exists, compile, artifacts);
}

Result<void> print_summary(const SummaryFlags& flags, const VerdictFiles& files,
                           const CompilePlan& compile, const ArtifactSet& artifacts) {
  const std::string& output = files.map;
  std::error_code failure;
  if (!std::filesystem::is_regular_file(output, failure)) return {};
  SIGHTLINE_ASSIGN(const CheckedMap written, read_map_without_nds(output));
  const MapJudgement judgement = judge_map(written.map, nullptr, files);
  if (flags.format == "json") {
    print_data(json_text(to_json({output, written.map, written.summary, judgement})));
    return {};
  }
  print_written(output, extent_text(written.map.sites));
  print_text(with_toned_verdict(judgement, to_text(judgement)));
  if (!flags.prints_tables) return {};
  SIGHTLINE_ASSIGN(const std::string tables, tables_text(compile, artifacts));
  print_text("\n" + tables);
  return {};
}

void add_summary_flags(Verb& verb, SummaryFlags& flags) {
  verb.flags.push_back({.names = "--format",
                        .value = "FORMAT",
                        .help = "Form of what is printed of the map; json: as "
                                "schemas/inspect.schema.json describes it",
                        .target = &flags.format,
                        .choices = {"text", "json"}});
  verb.flags.push_back(
      {.names = "--tables",
       .help = "Also print the tables of errors and times at each range, judged "
               "on the localization drive by models that were not trained on the place",
       .target = &flags.prints_tables});
}

void add_compile_flags(Verb& verb, CompileFlags& flags) {
  const std::vector<Flag> all = {
      ending_in(".slmap", output_flag(flags.output, "The map to write (.slmap)")),
      force_flag(flags.is_forced),
      {.names = "--model",
       .value = "FILE",
       .help =
           "Use the error model of this file (.slmodel, of `sightline train`) or map (.slmap) "
           "instead of that of annotation.model; errors of the localization drive are its inputs",
       .target = &flags.model},
      {.names = "--risk",
       .value = "SHARE",
       .help = "Share of the answered places that may miss their limit on the next drive "
               "(choose-ranges.alpha)",
       .target = risk_setter(flags)},
      {.names = "--strict",
       .help =
           "Guarantee the share of --risk with a confidence of 90 % (1 - choose-ranges.delta) "
           "instead of on average over drives; needs more route, for 5 % about 2.7 km instead of "
           "1.2 km",
       .target = strict_setter(flags)},
      {.names = "--list-inputs",
       .help = "Print every file that this compile would read, one a line, and end",
       .target = &flags.lists_inputs},
      {.names = "--dry-run",
       .help = "Open recordings and outputs, print which passes would run and about how much time, "
               "memory and disk they would take (--format json: as schemas/cost.schema.json "
               "describes it), and end",
       .target = &flags.is_dry},
      {.names = "--depfile",
       .value = "FILE",
       .help = "Also write what the map depends on to this file, as Make and Ninja read it",
       .target = &flags.depfile}};
  verb.flags.insert(verb.flags.end(), all.begin(), all.end());
  add_summary_flags(verb, flags.summary);
}

}  // namespace sightline
