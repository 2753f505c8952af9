#include <memory>
#include <nlohmann/json.hpp>

#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/work/shared_work.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

struct StatusFlags {
  std::string plan;
  std::string format = "text";
};

std::string state_text(const StepState& state) {
  if (state.is_done) return "done";
  if (state.parts == 0) return "-";
  return std::to_string(state.parts_there) + " of " + std::to_string(state.parts) + " parts";
}

std::string to_text(const std::vector<StepState>& states) {
  TextGrid grid = {{"stage", "step", "state"}};
  for (const StepState& state : states) {
    grid.push_back({std::string(stage_name(state.stage)), state.step, state_text(state)});
  }
  return aligned(grid, FirstColumn::kLeft);
}

std::string to_json(const std::vector<StepState>& states) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const StepState& state : states) {
    json.push_back({{"stage", stage_name(state.stage)},
                    {"step", state.step},
                    {"is_done", state.is_done},
                    {"parts_there", state.parts_there},
                    {"parts", state.parts}});
  }
  return json.dump(2) + "\n";
}

Result<void> status(const StatusFlags& flags) {
  SIGHTLINE_ASSIGN(const SharedWork work, open_work(flags.plan));
  const std::vector<StepState> states = states_of(work);
  if (flags.format == "json") {
    print_data(to_json(states));
  } else {
    print_text(to_text(states));
  }
  return {};
}

}  // namespace

Verb status_verb() {
  const auto flags = std::make_shared<StatusFlags>();
  Verb verb;
  verb.name = "status";
  verb.summary = "Tell how far the work on a plan is";
  verb.details =
      "One line a step. Parts are counted from when a process has begun the step, and are given "
      "for "
      "steps that are not finished.";
  verb.examples = {"sightline status plan/", "sightline status plan/ --format json"};
  verb.positionals = {
      {.name = "PLAN", .help = "The folder that `sightline plan` wrote", .target = &flags->plan}};
  verb.flags = {{.names = "--format",
                 .value = "FORMAT",
                 .help = "Form of the output; json: an array, one object a step",
                 .target = &flags->format,
                 .choices = {"text", "json"}}};
  verb.run = [flags] { return exit_status_of(status(*flags)); };
  return verb;
}

}  // namespace sightline
