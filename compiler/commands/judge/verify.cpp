#include <memory>
#include <nlohmann/json.hpp>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/result_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/model_source.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/text/describe.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_file.h"
#include "formats/map/map_reader.h"
#include "passes/emit/prove_annotation.h"

namespace sightline {
namespace {

struct VerifyFlags {
  std::string map;
  ResultFlags result;
  bool prints_tables = false;
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
  SIGHTLINE_ASSIGN(const ChosenModel model, choose_model(config, flags.model));
  const CompilePlan compile = compile_plan(config, model.source());
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(run), artifacts));
  SIGHTLINE_TRY(provide_model(compile, model.file, artifacts));
  SIGHTLINE_TRY(run_steps(compile.plan, {compile.map}, run, config, artifacts));
  return artifacts.get(compile.map);
}

// Bit for bit: the one proof that no cache, machine or hand has changed what the drives give.
Result<void> check_against_drives(const VerifyFlags& flags) {
  SIGHTLINE_ASSIGN(const MapFile again, compile_again(flags));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> found, read_file(flags.map));
  SIGHTLINE_ASSIGN(const std::vector<std::byte> expected, again.bytes.read(0, again.bytes.size()));
  if (found == expected) return {};
  return Error{ErrorCode::kDigestMismatch,
               concat("compiled again without a cache it is another map, of SHA-256 ",
                      to_hex(sha256(expected)),
                      ": other drives, options or program, or a cache that "
                      "somebody else wrote to"),
               flags.map};
}

// "town.slmap: checked every digest, checksum, bound and order of 12 tiles, 601 sites and ..."
std::string checked_text(const VerifyFlags& flags, const MapSummary& summary) {
  std::uint64_t blocks = 2;  // manifest and directory
  for (const MapSummary::Blocks& each : summary.blocks) blocks += each.block_count;
  return concat(flags.map, ": checked every digest, checksum, bound and order in ", blocks,
                " blocks of ", summary.tile_count, " tiles (", size_text(summary.file_size),
                ", format ", summary.format, "): no fault\n");
}

// In the order in which it was checked.
struct Checked {
  MapSummary summary;
  bool is_compiled_again = false;
  std::optional<AnnotationProof> proof;
};

std::string text_of(const VerifyFlags& flags, const Checked& checked) {
  std::string text = checked_text(flags, checked.summary);
  if (checked.is_compiled_again) text += "compiled again it is the same, bit for bit\n";
  if (checked.proof) text += to_text(*checked.proof);
  return flags.prints_tables ? text + describe(checked.summary) : text;
}

std::string json_of(const VerifyFlags& flags, const Checked& checked) {
  using Json = nlohmann::ordered_json;
  Json blocks = Json::array();
  for (const MapSummary::Blocks& each : checked.summary.blocks) {
    blocks.push_back({{"name", each.name},
                      {"blocks", each.block_count},
                      {"rows", each.row_count},
                      {"raw_size", each.raw_size},
                      {"stored_size", each.stored_size}});
  }
  const Json json = {{"schema", 1},
                     {"file", flags.map},
                     {"format", checked.summary.format},
                     {"size", checked.summary.file_size},
                     {"root_digest", to_hex(checked.summary.root_digest)},
                     {"tiles", checked.summary.tile_count},
                     {"is_compiled_again", checked.is_compiled_again},
                     {"proven_sites", checked.proof ? Json(checked.proof->site_count) : Json()},
                     {"blocks", blocks}};
  return json_text(json);
}

Result<AnnotationProof> prove(const VerifyFlags& flags) {
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.map));
  PassContext ctx;
  ctx.threads = 0;
  Result<AnnotationProof> proof = prove_annotation(ctx, map);
  if (!proof) return in_file(proof.error(), flags.map);
  return proof;
}

Result<void> verify(const VerifyFlags& flags) {
  SIGHTLINE_TRY(try_result(flags.result));
  Checked checked;
  SIGHTLINE_ASSIGN(checked.summary, verify_map(flags.map));
  if (!flags.config.empty()) {
    SIGHTLINE_TRY(check_against_drives(flags));
    checked.is_compiled_again = true;
  }
  if (flags.is_deep) {
    SIGHTLINE_ASSIGN(checked.proof, prove(flags));
  }
  return put_result(flags.result,
                    flags.result.is_json() ? json_of(flags, checked) : text_of(flags, checked));
}

}  // namespace

Verb verify_verb() {
  const auto flags = std::make_shared<VerifyFlags>();
  Verb verb;
  verb.name = "verify";
  verb.summary = "Check every digest, checksum, bound and order of a map; names the first fault";
  verb.details =
      "--deep computes the annotation again from the map's own factors and forest, and every "
      "prediction, range, flag and promise must be the same, bit for bit. --again compiles the "
      "whole map again from the drives, without a cache, and it must be the same. This also "
      "detects "
      "a cache that another user changed.";
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
       .target = &flags->overrides},
      {.names = "--tables",
       .help = "Also print the parts of the file with their sizes",
       .target = &flags->prints_tables}};
  add_result_flags(verb, flags->result, {"text", "json"},
                   "json as schemas/verify.schema.json describes it");
  verb.run = [flags] { return exit_status_of(verify(*flags)); };
  return verb;
}

}  // namespace sightline
