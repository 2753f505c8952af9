#include "compiler/commands/commands.h"

#include "built_with.h"
#include "commit.h"
#include "formats/base/version.h"
#include "formats/model/error_model.h"
#include "formats/reader/map_layout.h"
#include "passes/matching/kernel_score.h"

namespace sightline {
namespace {

void add_group(Program& program, const std::string& group, const std::vector<Verb>& verbs) {
  for (const Verb& verb : verbs) {
    program.verbs.push_back(verb);
    program.verbs.back().group = group;
  }
}

std::string kernels() {
  std::string names(kernel_name(fastest_kernel()));
  for (const MatchKernel kernel :
       {MatchKernel::kAvx512, MatchKernel::kAvx2, MatchKernel::kPortable}) {
    if (kernel == fastest_kernel() || !is_supported(kernel)) continue;
    names += ", " + std::string(kernel_name(kernel));
  }
  return names;
}

std::string line(std::string name, const std::string& value) {
  constexpr std::size_t kWidth = 15;
  name.resize(kWidth, ' ');
  return concat(name, value, "\n");
}

}  // namespace

Program sightline_program() {
  Program program;
  program.name = "sightline";
  program.version = program_version();
  program.build = build_details();
  program.summary =
      "sightline compiles recorded drives into a map of how far a vehicle must look at "
      "each place.";
  program.first_steps = {
      "sightline init recordings/ -o drive.yaml       # look at them, write a configuration",
      "sightline compile drive.yaml -o drive.slmap    # make the map",
      "sightline inspect drive.slmap                  # what the map says of itself"};
  program.details =
      "Data goes to stdout, log and progress to stderr, in colour only on a terminal and without "
      "NO_COLOR. Exit status: 0 done, 64 usage, 65 input, 66 version, 67 corrupt, 68 signature, 69 "
      "gate, 74 system, 75 incomplete; diff alone: 0 same, 1 different, 2 trouble. "
      "schemas/error_codes.md lists every failure with its remedy.";
  add_group(program, "Make a map",
            {init_verb(), compile_verb(), annotate_verb(), train_verb(), cache_verb()});
  add_group(program, "Make a map on many machines",
            {plan_verb(), work_verb(), link_verb(), status_verb()});
  add_group(program, "Look at it",
            {inspect_verb(), weak_verb(), dump_verb(), export_verb(), report_verb()});
  add_group(program, "Judge it", {verify_verb(), evaluate_verb(), diff_verb(), gate_verb()});
  add_group(program, "Change a map file",
            {delta_verb(), apply_verb(), strip_verb(), recover_verb()});
  add_group(program, "Release it to a fleet",
            {key_verb(), root_verb(), release_verb(), sign_verb(), admit_verb()});
  add_group(program, "About the program", {passes_verb(), completion_verb(), man_verb()});
  add_group(program, "About the program", {help_verb(verb_names(program))});
  return program;
}

std::string build_details() {
  return line("commit", SIGHTLINE_COMMIT) + line("map format", to_string(kFormatVersion)) +
         line("model format", std::to_string(ArtifactTraits<ErrorModel>::kVersion)) +
         line("configuration", "schema " SIGHTLINE_CONFIG_SCHEMA) + line("kernels", kernels()) +
         line("libraries", SIGHTLINE_LIBRARIES);
}

}  // namespace sightline
