#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/result_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/map/compile_to_map.h"
#include "compiler/driver/pipelines.h"
#include "compiler/work/shared_work.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

struct WorkFlags {
  std::string plan;
  std::string stage;
  WorkShare share;
  RunFlags run;
};

// "7/64": the seventh of 64.
Result<WorkShare> parse_share(const std::string& text) {
  const Error wrong{ErrorCode::kBadArgument,
                    concat("found '", text, "', expected K/N with 1 <= K <= N, such as 7/64")};
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return wrong;
  const auto number_in = [](std::string_view digits) -> std::size_t {
    std::size_t number = 0;
    const auto [end, failure] = std::from_chars(digits.begin(), digits.end(), number);
    return failure == std::errc() && end == digits.end() ? number : 0;
  };
  const std::size_t number = number_in(std::string_view(text).substr(0, slash));
  const std::size_t of = number_in(std::string_view(text).substr(slash + 1));
  if (number == 0 || number > of || of > 1000000) return wrong;
  return WorkShare{number - 1, of};
}

Result<void> work(const WorkFlags& flags) {
  SIGHTLINE_ASSIGN(SharedWork work, open_work(flags.plan));
  const Stage stage = *stage_named(flags.stage);
  RunOptions options = options_in(work, stage);
  options.threads = flags.run.threads;
  options.share = flags.share;
  options.keeps_wanted = false;  // others take it from the store
  options.must_store = true;
  std::vector<AnyWire> others = outputs_of(work.compile, stage);
  const std::vector<AnyWire> own = share_of(others, flags.share);
  std::erase_if(others,
                [&](const AnyWire& output) { return std::ranges::find(own, output) != own.end(); });
  for (const std::vector<AnyWire>& wanted : {own, others}) {
    if (wanted.empty()) continue;
    SIGHTLINE_TRY(
        run_steps(work.compile.plan, wanted, flags.run, options, work.config, work.artifacts));
  }
  return {};
}

struct StatusFlags {
  std::string plan;
  ResultFlags result;
};

std::string state_text(const StepState& state) {
  if (state.is_done) return "done";
  if (state.parts == 0) return "-";
  return concat(state.parts_there, " of ", state.parts, " parts");
}

std::string to_text(const std::vector<StepState>& states) {
  TextGrid grid = {{"stage", "step", "state"}};
  for (const StepState& state : states) {
    grid.push_back({std::string(stage_name(state.stage)), state.step, state_text(state)});
  }
  return aligned(grid, FirstColumn::kLeft);
}

Result<void> status(const StatusFlags& flags) {
  SIGHTLINE_ASSIGN(const SharedWork work, open_work(flags.plan));
  const std::vector<StepState> states = states_of(work);
  return put_result(flags.result, flags.result.is_json() ? to_json(states) : to_text(states));
}

struct LinkFlags {
  std::string plan;
  std::string output;
  bool is_forced = false;
  SummaryFlags summary;
  RunFlags run;
};

Result<void> link(const LinkFlags& flags) {
  SIGHTLINE_TRY(try_outputs_of_map(flags.output, if_exists(flags.is_forced)));
  const std::string output = std::filesystem::absolute(flags.output).string();
  SIGHTLINE_ASSIGN(SharedWork work, open_work(flags.plan));
  SIGHTLINE_TRY(try_poses_output(output, if_exists(flags.is_forced), work.compile));
  RunOptions options = options_in(work, Stage::kLink);
  options.threads = flags.run.threads;
  SIGHTLINE_ASSIGN(const std::vector<StepReport> reports,
                   run_steps(work.compile.plan, reported_artifacts(work.compile), flags.run,
                             options, work.config, work.artifacts));
  SIGHTLINE_TRY(write_compiled(output, if_exists(flags.is_forced), work.config, work.compile,
                               work.artifacts, reports));
  if (flags.run.is_quiet) return {};
  return print_summary(flags.summary, {.map = output}, work.compile, work.artifacts);
}

Positional plan_positional(std::string& folder) {
  return {
      .name = "PLAN", .help = "The folder that `sightline cluster plan` wrote", .target = &folder};
}

void add_flags_of_work(Verb& verb, RunFlags& run) {
  for (const Flag& flag : {threads_flag(run.threads), time_passes_flag(run.time_passes),
                           json_progress_flag(run.json_progress), quiet_flag(run.is_quiet),
                           verbose_flag(run.is_verbose)}) {
    verb.flags.push_back(flag);
  }
}

}  // namespace

Verb work_verb() {
  const auto flags = std::make_shared<WorkFlags>();
  std::vector<std::string> stages;
  for (const Stage stage : kWorkStages) stages.emplace_back(stage_name(stage));
  Verb verb;
  verb.name = "cluster work";
  verb.summary = "Do one share of one stage of a plan";
  verb.details =
      "Computes what the stage still lacks: first this share, then parts of other shares that are "
      "not finished. So one process alone completes a stage. Any number of processes may work on "
      "the same stage or share, and each may be killed at any time: finished parts are complete "
      "files in the store of the plan, and a part that is computed twice has the same bytes.\n\n"
      "Units of work: drives: one recording. graph: one. tiles: parts of 128 m. sites: groups of "
      "neighbouring places. learn: one. If the stage before is not finished, the exit status is 75 "
      "and the missing parts are listed.";
  verb.examples = {"sightline cluster work plan/ --stage sites --share 7/64",
                   "sightline cluster work plan/ --stage graph"};
  verb.positionals = {plan_positional(flags->plan)};
  verb.flags = {{.names = "--stage",
                 .value = "STAGE",
                 .help = "The stage to work on",
                 .target = &flags->stage,
                 .choices = stages,
                 .is_required = true},
                {.names = "--share",
                 .value = "K/N",
                 .help = "Do the K-th of N shares first; default: 1/1",
                 .target = Setter([flags](const std::string& text) -> Result<void> {
                   SIGHTLINE_ASSIGN(flags->share, parse_share(text));
                   return {};
                 })}};
  add_flags_of_work(verb, flags->run);
  verb.run = [flags] { return exit_status_of(work(*flags)); };
  return verb;
}

Verb status_verb() {
  const auto flags = std::make_shared<StatusFlags>();
  Verb verb;
  verb.name = "cluster status";
  verb.summary = "Show the progress of a plan";
  verb.details =
      "Prints one line a step. An unfinished step shows its finished parts once a process has "
      "started it.";
  verb.examples = {"sightline cluster status plan/",
                   "sightline cluster status plan/ --format json    # status.schema.json"};
  verb.positionals = {plan_positional(flags->plan)};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json: one object a step, as schemas/status.schema.json describes it");
  verb.run = [flags] { return exit_status_of(status(*flags)); };
  return verb;
}

Verb link_verb() {
  const auto flags = std::make_shared<LinkFlags>();
  Verb verb;
  verb.name = "cluster link";
  verb.summary = "Make the map of a finished plan";
  verb.details =
      "The map, its provenance and the output are the same as those of `sightline compile` with "
      "the same configuration. If work is missing, the exit status is 75 and it is listed.";
  verb.examples = {"sightline cluster link plan/ -o city.slmap"};
  verb.positionals = {plan_positional(flags->plan)};
  verb.flags = {
      ending_in(".slmap", required_output_flag(flags->output, "The map to write (.slmap)")),
      force_flag(flags->is_forced)};
  add_summary_flags(verb, flags->summary);
  add_flags_of_work(verb, flags->run);
  verb.run = [flags] { return exit_status_of(link(*flags)); };
  return verb;
}

}  // namespace sightline
