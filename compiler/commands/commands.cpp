#include "compiler/commands/commands.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "built_with.h"
#include "commit.h"
#include "compiler/cli/common_flags.h"
#include "formats/base/version.h"
#include "formats/model/error_model.h"
#include "formats/reader/map_layout.h"
#include "formats/text/json_text.h"
#include "passes/matching/kernel_score.h"

namespace sightline {
namespace {

void add_group(Program& program, const std::string& group, const std::vector<Verb>& verbs) {
  for (const Verb& verb : verbs) {
    program.verbs.push_back(verb);
    program.verbs.back().group = group;
    add_verbosity_flags(program.verbs.back());
    add_thread_limit(program.verbs.back());
  }
}

// Names of before 0.1.0; they end with 0.2.0 (schemas/changes.md).
std::vector<std::pair<std::string, std::string>> old_names() {
  return {{"plan", "cluster plan"},     {"work", "cluster work"}, {"link", "cluster link"},
          {"status", "cluster status"}, {"key", "fleet key"},     {"root", "fleet root"},
          {"release", "fleet release"}, {"sign", "fleet sign"},   {"admit", "fleet admit"},
          {"delta", "delta make"},      {"apply", "delta apply"}};
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

// A name and its value, as --version prints them and as a key of its JSON.
struct BuildFact {
  std::string name;
  std::string value;
};

std::vector<BuildFact> build_facts() {
  return {{"commit", SIGHTLINE_COMMIT},
          {"map format", to_string(kFormatVersion)},
          {"model format", std::to_string(ArtifactTraits<ErrorModel>::kVersion)},
          {"configuration", "schema " SIGHTLINE_CONFIG_SCHEMA},
          {"kernels", kernels()},
          {"libraries", SIGHTLINE_LIBRARIES}};
}

std::string version_json(const Program& program) {
  nlohmann::ordered_json json = {{"program", program.name}, {"version", program.version}};
  for (BuildFact fact : build_facts()) {
    std::ranges::replace(fact.name, ' ', '_');
    json[fact.name] = fact.value;
  }
  return json_text(json);
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
  program.version_json = version_json(program);
  program.summary =
      "sightline compiles recorded drives into a map of how far a vehicle must look at "
      "each place.";
  program.first_steps = {
      "sightline init recordings/ -o drive.yaml       # examine them, write a configuration",
      "sightline compile drive.yaml -o drive.slmap    # make the map",
      "sightline inspect drive.slmap                  # summary, verdict and next steps"};
  program.details =
      "Results go to stdout, log and progress to stderr. Colours are used only on a terminal, and "
      "not if NO_COLOR is set. Exit status: 0 done, 64 usage, 65 input, 66 version, 67 corrupt, 68 "
      "signature, 69 gate, 74 system, 75 incomplete; of diff: 0 same, 1 different, 2 failed. "
      "schemas/error_codes.md lists every error with its remedy.";
  program.families = {{"cluster", "Make one map with many processes or machines"},
                      {"delta", "Make and apply the difference between two maps"},
                      {"fleet", "Sign maps, and check them in the vehicle"}};
  program.aliases = old_names();
  add_group(program, "Make a map",
            {init_verb(), compile_verb(), annotate_verb(), train_verb(), cache_verb(), plan_verb(),
             work_verb(), link_verb(), status_verb()});
  add_group(program, "Look at a map",
            {inspect_verb(), weak_verb(), dump_verb(), export_verb(), report_verb()});
  add_group(
      program, "Judge a map",
      {verify_verb(), evaluate_verb(), localize_verb(), tune_verb(), diff_verb(), gate_verb()});
  add_group(program, "Change and release a map",
            {strip_verb(), recover_verb(), delta_verb(), apply_verb(), key_verb(), root_verb(),
             release_verb(), sign_verb(), admit_verb()});
  add_group(program, "About the program",
            {passes_verb(), completion_verb(), man_verb(), help_verb()});
  return program;
}

std::string build_details() {
  std::string text;
  for (const BuildFact& fact : build_facts()) text += line(fact.name, fact.value);
  return text;
}

}  // namespace sightline
