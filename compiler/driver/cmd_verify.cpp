#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/describe.h"
#include "formats/map/map_reader.h"
#include "passes/prove_annotation.h"

namespace sightline {
namespace {

struct VerifyFlags {
  std::string map;
  bool is_deep = false;
};

Result<void> verify(const VerifyFlags& flags) {
  const Result<MapSummary> checked = verify_map(flags.map);
  if (!checked) return checked.error();
  std::fputs(describe(*checked).c_str(), stdout);
  if (!flags.is_deep) return {};
  const Result<CompiledMap> map = read_map(flags.map);
  if (!map) return map.error();
  PassContext ctx;
  ctx.threads = 0;
  const Result<AnnotationProof> proof = prove_annotation(ctx, *map);
  if (!proof) {
    Error error = proof.error();
    error.file = flags.map;
    return error;
  }
  std::fputs(to_text(*proof).c_str(), stdout);
  return {};
}

}  // namespace

void add_verify_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<VerifyFlags>();
  CLI::App* command = app.add_subcommand(
      "verify", "Check every digest, checksum, bound and order of a map; names the first fault");
  command->footer(
      "With --deep the annotation is made again from the map's own factors and forest, and every\n"
      "prediction, range, flag and promise must be the same, bit for bit.\n\n"
      "Examples:\n"
      "  sightline verify town.slmap && cp town.slmap /srv/maps/\n"
      "  sightline verify town.slmap --deep");
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_flag("--deep", flags->is_deep, "Also prove that each site's annotation follows");
  command->callback([flags, &status] {
    const Result<void> verified = verify(*flags);
    status = verified ? 0 : report_error(verified.error());
  });
}

}  // namespace sightline
