#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/repair/repack.h"
#include "formats/reader/mapped_file.h"

// The verb that writes a map anew without computing anything: strip.

namespace sightline {
namespace {

struct StripFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> strip(const StripFlags& flags) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(flags.map));
  const Result<Repacked> result = strip_map(file.bytes());
  if (!result) return in_file(result.error(), flags.map);
  SIGHTLINE_TRY(write_file_atomically(flags.output, result->file,
                                      flags.force ? IfExists::kReplace : IfExists::kRefuse));
  for (const std::string& line : result->actions) print_text(line + "\n");
  std::printf("%zu bytes, were %zu\n", result->file.size(), file.bytes().size());
  return {};
}

}  // namespace

Verb strip_verb() {
  const auto flags = std::make_shared<StripFlags>();
  Verb verb;
  verb.name = "strip";
  verb.summary = "Write a map without what only engineers need; no other digest changes";
  verb.details =
      "Drops the map factors and the error model. The root digest stays, and so does a signature.";
  verb.examples = {"sightline strip town.slmap -o town.vehicle.slmap"};
  verb.positionals = {map_positional(flags->map, "The map to read")};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(strip(*flags)); };
  return verb;
}

}  // namespace sightline
