#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/text/describe.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_file.h"
#include "formats/map/map_reader.h"
#include "passes/emit/prove_annotation.h"

namespace sightline {
namespace {

struct VerifyFlags {
  std::string map;
  bool is_deep = false;
  std::string config;  // empty: not compiled again
  std::string model;
  std::vector<std::string> overrides;
};

Result<MapFile> compile_again(const VerifyFlags& flags) {
  RunFlags run;
  run.config_file = flags.config;
  run.overrides = flags.overrides;
  run.no_cache = true;  // what somebody put there has no part in it
  run.is_quiet = true;
  SIGHTLINE_ASSIGN(const CompileConfig config, load_compile_config(run.config_file, run.overrides));
  const CompilePlan compile =
      compile_plan(config, flags.model.empty() ? ModelSource::kTrained : ModelSource::kGiven);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(run), artifacts));
  SIGHTLINE_TRY(provide_model(compile, flags.model, artifacts));
  SIGHTLINE_TRY(run_steps(compile.plan, {compile.map}, run, config, artifacts));
  return artifacts.get(compile.map);
}

// Bit for bit: the one proof that no cache, machine or hand has changed what the drives give.
Result<void> check_against_drives(const VerifyFlags& flags) {
  SIGHTLINE_ASSIGN(const MapFile again, compile_again(flags));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> found, read_file(flags.map));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> expected, again.bytes.read(0, again.bytes.size()));
  if (found == expected) {
    std::printf("compiled again it is the same, bit for bit\n");
    return {};
  }
  return Error{ErrorCode::kDigestMismatch,
               concat("compiled again without a cache it is another map, of SHA-256 ",
                      to_hex(sha256(expected)),
                      ": other drives, options or program, or a cache that "
                      "somebody else wrote to"),
               flags.map};
}

Result<void> verify(const VerifyFlags& flags) {
  SIGHTLINE_ASSIGN(const MapSummary checked, verify_map(flags.map));
  print_text(describe(checked));
  if (!flags.config.empty()) SIGHTLINE_TRY(check_against_drives(flags));
  if (!flags.is_deep) return {};
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.map));
  PassContext ctx;
  ctx.threads = 0;
  const Result<AnnotationProof> proof = prove_annotation(ctx, map);
  if (!proof) return in_file(proof.error(), flags.map);
  print_text(to_text(*proof));
  return {};
}

}  // namespace

Verb verify_verb() {
  const auto flags = std::make_shared<VerifyFlags>();
  Verb verb;
  verb.name = "verify";
  verb.summary = "Check every digest, checksum, bound and order of a map; names the first fault";
  verb.details =
      "With --deep the annotation is made again from the map's own factors and forest, and every "
      "prediction, range, flag and promise must be the same, bit for bit. What it was made of is "
      "taken as it stands: with --again the whole map is compiled anew from the drives, without a "
      "cache, and must be the same. That finds also what somebody put into a cache.";
  verb.examples = {"sightline verify town.slmap && cp town.slmap /srv/maps/",
                   "sightline verify town.slmap --deep",
                   "sightline verify town.slmap --again town.yaml"};
  verb.positionals = {map_positional(flags->map, "The map to check")};
  verb.flags = {
      {.names = "--deep",
       .help = "Also prove that each site's annotation follows",
       .target = &flags->is_deep},
      {.names = "--again",
       .value = "CONFIG",
       .help = "Also compile this configuration again and compare",
       .target = &flags->config},
      {.names = "--model",
       .value = "FILE",
       .help = "Use the error model of this file for --again, as the compile of the map did",
       .target = &flags->model},
      {.names = "--set",
       .value = "KEY=VALUE",
       .help = "Override one value of the configuration for --again, as the compile of the map did",
       .target = &flags->overrides}};
  verb.run = [flags] { return exit_status_of(verify(*flags)); };
  return verb;
}

}  // namespace sightline
