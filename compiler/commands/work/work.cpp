#include <algorithm>
#include <charconv>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/work/shared_work.h"

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
                    "found '" + text + "', expected K/N with 1 <= K <= N, such as 7/64"};
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

Setter share_setter(WorkFlags& flags) {
  return [&flags](const std::string& text) -> Result<void> {
    SIGHTLINE_ASSIGN(flags.share, parse_share(text));
    return {};
  };
}

Result<void> work(const WorkFlags& flags) {
  SIGHTLINE_ASSIGN(SharedWork work, open_work(flags.plan));
  const Stage stage = *stage_named(flags.stage);
  const Plan& plan = work.compile.plan;
  RunOptions options = options_in(work, stage);
  options.threads = flags.run.threads;
  options.share = flags.share;
  options.keeps_wanted = false;  // others take it from the store
  std::vector<AnyWire> others = outputs_of(work.compile, stage);
  const std::vector<AnyWire> own = share_of(others, flags.share);
  std::erase_if(others,
                [&](const AnyWire& output) { return std::ranges::find(own, output) != own.end(); });
  for (const std::vector<AnyWire>& wanted : {own, others}) {
    if (wanted.empty()) continue;
    SIGHTLINE_TRY(run_steps(plan, wanted, flags.run, options, work.config, work.artifacts));
  }
  return {};
}

std::vector<std::string> names_of_stages() {
  std::vector<std::string> names;
  for (const Stage stage : kWorkStages) names.emplace_back(stage_name(stage));
  return names;
}

}  // namespace

Verb work_verb() {
  const auto flags = std::make_shared<WorkFlags>();
  Verb verb;
  verb.name = "work";
  verb.summary = "Do a share of one stage of a plan";
  verb.details =
      "Makes what is missing of the stage: first what falls to this share, then what others have "
      "not made yet, so that one process alone does all of it. Any number may be at work on the "
      "same stage, on the same share too, and be killed at any moment: finished parts are whole "
      "files in the store of the plan, and what is made twice has the same bytes.\n\n"
      "drives: one unit a recording. graph: one unit. tiles: parts of 128 m. sites: places that "
      "stand together. learn: one unit. A stage whose predecessor is not finished ends with exit "
      "status 75 and the list of what is missing.";
  verb.examples = {"sightline work plan/ --stage sites --share 7/64",
                   "sightline work plan/ --stage graph"};
  verb.positionals = {
      {.name = "PLAN", .help = "The folder that `sightline plan` wrote", .target = &flags->plan}};
  verb.flags = {{.names = "--stage",
                 .value = "STAGE",
                 .help = "What to work on",
                 .target = &flags->stage,
                 .choices = names_of_stages(),
                 .is_required = true},
                {.names = "--share",
                 .value = "K/N",
                 .help = "Take the K-th of N shares first; else all of it is one share",
                 .target = share_setter(*flags)},
                threads_flag(flags->run.threads),
                time_passes_flag(flags->run.time_passes),
                json_progress_flag(flags->run.json_progress),
                quiet_flag(flags->run.is_quiet)};
  verb.run = [flags] { return exit_status_of(work(*flags)); };
  return verb;
}

}  // namespace sightline
