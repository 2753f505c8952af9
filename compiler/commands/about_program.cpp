#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "compiler/cli/help_text.h"
#include "compiler/cli/result_flags.h"
#include "compiler/cli/verb.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "formats/text/json_text.h"

// Verbs about the program itself: its passes and its command line.

namespace sightline {
namespace {

// Of no words, a family or a verb. Error: unknown-name.
Result<std::string> explained(const Program& program, const std::vector<std::string>& words) {
  if (words.empty()) return help_text(program);
  const Called called = find_called(program, words);
  if (called.word_count == words.size()) {
    if (called.verb == nullptr) return help_text(program, *called.family);
    return help_text(concat(program.name, " ", called.verb->name), *called.verb);
  }
  return Error{ErrorCode::kUnknownName, concat("'", joined(words, " "), "' is not a verb; `",
                                               program.name, " help` lists all")};
}

struct PassesFlags {
  ResultFlags result;
  bool print_schema = false;
  bool print_config = false;
};

// Of a compile with a localization drive, which runs every pass.
Plan plan_of_all() {
  CompileConfig config;
  config.mapping.scans = "mapping/scans";
  config.localization.scans = "drive/scans";
  return compile_plan(config).plan;
}

std::vector<std::string> inputs_of(const Plan& plan, const PassStep& step) {
  std::vector<std::string> names;
  for (const std::size_t input : step.inputs) names.push_back(plan.artifact({input}).name);
  return names;
}

std::string passes_text(const Plan& plan) {
  std::string text;
  for (const PassStep& step : plan.steps()) {
    text += concat(step.name, " (version ", step.version, ")\n  ", joined(inputs_of(plan, step)),
                   " -> ", plan.artifact({step.output}).name, "\n");
    for (const auto& [name, value] : step.options) {
      text += concat("    ", name, " = ", value, "\n");
    }
  }
  return text;
}

std::string passes_json(const Plan& plan) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const PassStep& step : plan.steps()) {
    nlohmann::ordered_json options = nlohmann::ordered_json::object();
    for (const auto& [name, value] : step.options) options[name] = value;
    json.push_back({{"pass", step.name},
                    {"version", step.version},
                    {"inputs", inputs_of(plan, step)},
                    {"output", plan.artifact({step.output}).name},
                    {"options", std::move(options)}});
  }
  return json_text(json);
}

Result<void> run_passes(const PassesFlags& flags) {
  CompileConfig config;
  if (flags.print_schema)
    return put_result(flags.result, to_json_schema(published_sections(config)));
  if (flags.print_config) return put_result(flags.result, to_yaml(published_sections(config)));
  const Plan plan = plan_of_all();
  return put_result(flags.result, flags.result.is_json() ? passes_json(plan) : passes_text(plan));
}

}  // namespace

Verb man_verb() {
  Verb verb;
  verb.name = "man";
  verb.summary = "Print the manual page";
  verb.examples = {"sightline man | man -l -",
                   "sightline man > ~/.local/share/man/man1/sightline.1"};
  verb.run = []() -> Result<int> {
    std::fputs(man_page(sightline_program()).c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb help_verb() {
  const auto words = std::make_shared<std::vector<std::string>>();
  Verb verb;
  verb.name = "help";
  verb.summary = "Explain a verb with examples, or list all verbs";
  verb.details = "`sightline help VERB` prints the same as `sightline VERB --help`.";
  verb.examples = {"sightline help", "sightline help compile", "sightline help cluster plan"};
  verb.positionals = {{.name = "VERB",
                       .help = "The verb to explain, one word or two",
                       .target = words.get(),
                       .is_required = false}};
  verb.run = [words]() -> Result<int> {
    const Program program = sightline_program();
    SIGHTLINE_ASSIGN(const std::string text, explained(program, *words));
    std::fputs(text.c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb passes_verb() {
  const auto flags = std::make_shared<PassesFlags>();
  Verb verb;
  verb.name = "passes";
  verb.summary = "List the passes of a compile in their order";
  verb.examples = {
      "sightline passes                         # names, inputs, outputs, options",
      "sightline passes --format json           # the same (schemas/passes.schema.json)",
      "sightline passes --schema > config.json  # JSON Schema of the configuration",
      "sightline passes --config > drive.yaml   # a configuration with every default"};
  verb.flags = {{.names = "--schema",
                 .help = "Print the JSON Schema of the configuration",
                 .target = &flags->print_schema},
                {.names = "--config",
                 .help = "Print a commented configuration with every default",
                 .target = &flags->print_config,
                 .excludes = "--schema"}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json: one object a pass, as schemas/passes.schema.json describes it");
  verb.run = [flags] { return exit_status_of(run_passes(*flags)); };
  return verb;
}

}  // namespace sightline
