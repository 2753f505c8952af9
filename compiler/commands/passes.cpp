#include <cstdio>
#include <memory>
#include <string>

#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"

namespace sightline {
namespace {

struct PassesFlags {
  bool print_schema = false;
  bool print_config = false;
};

// The example a newcomer sees: a compile with a localization drive, so that every pass is in it.
CompileConfig complete_config() {
  CompileConfig config;
  config.mapping.scans = "mapping/scans";
  config.localization.scans = "drive/scans";
  return config;
}

void print_passes() {
  const Plan plan = compile_plan(complete_config()).plan;
  for (const PassStep& step : plan.steps()) {
    std::string inputs;
    for (const std::size_t input : step.inputs) {
      inputs += (inputs.empty() ? "" : ", ") + plan.artifact({input}).name;
    }
    std::printf("%s (version %u)\n  %s -> %s\n", step.name.c_str(), step.version, inputs.c_str(),
                plan.artifact({step.output}).name.c_str());
    for (const auto& [name, value] : step.options) {
      std::printf("    %s = %s\n", name.c_str(), value.c_str());
    }
  }
}

void run_passes(const PassesFlags& flags) {
  CompileConfig config;
  if (flags.print_schema) {
    std::fputs(to_json_schema(published_sections(config)).c_str(), stdout);
  } else if (flags.print_config) {
    std::fputs(to_yaml(published_sections(config)).c_str(), stdout);
  } else {
    print_passes();
  }
}

}  // namespace

Verb passes_verb() {
  const auto flags = std::make_shared<PassesFlags>();
  Verb verb;
  verb.name = "passes";
  verb.summary = "List the passes of a compile in their order";
  verb.examples = {"sightline passes                         # names, inputs, outputs, options",
                   "sightline passes --schema > config.json  # JSON Schema of the configuration",
                   "sightline passes --config > drive.yaml   # a configuration with every default"};
  verb.flags = {{.names = "--schema",
                 .help = "Print the JSON Schema of the configuration",
                 .target = &flags->print_schema},
                {.names = "--config",
                 .help = "Print a commented configuration with every default",
                 .target = &flags->print_config,
                 .excludes = "--schema"}};
  verb.run = [flags]() -> Result<int> {
    run_passes(*flags);
    return 0;
  };
  return verb;
}

}  // namespace sightline
