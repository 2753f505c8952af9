#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/views/text/describe.h"
#include "formats/map/map_reader.h"
#include "passes/emit/prove_annotation.h"

namespace sightline {
namespace {

struct VerifyFlags {
  std::string map;
  bool is_deep = false;
};

Result<void> verify(const VerifyFlags& flags) {
  SIGHTLINE_ASSIGN(const MapSummary checked, verify_map(flags.map));
  std::fputs(describe(checked).c_str(), stdout);
  if (!flags.is_deep) return {};
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.map));
  PassContext ctx;
  ctx.threads = 0;
  const Result<AnnotationProof> proof = prove_annotation(ctx, map);
  if (!proof) {
    Error error = proof.error();
    error.file = flags.map;
    return error;
  }
  std::fputs(to_text(*proof).c_str(), stdout);
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
      "prediction, range, flag and promise must be the same, bit for bit.";
  verb.examples = {"sightline verify town.slmap && cp town.slmap /srv/maps/",
                   "sightline verify town.slmap --deep"};
  verb.positionals = {map_positional(flags->map, "The map to check")};
  verb.flags = {{.names = "--deep",
                 .help = "Also prove that each site's annotation follows",
                 .target = &flags->is_deep}};
  verb.run = [flags] { return exit_status_of(verify(*flags)); };
  return verb;
}

}  // namespace sightline
