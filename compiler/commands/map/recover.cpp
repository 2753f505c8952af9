#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/recover.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

struct RecoverFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> recover(const RecoverFlags& flags) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(flags.map));
  const Result<Recovered> result = recover_map(file.bytes());
  if (!result) return in_file(result.error(), flags.map);
  SIGHTLINE_TRY(write_file_atomically(flags.output, encode_map(result->map),
                                      flags.force ? IfExists::kReplace : IfExists::kRefuse));
  for (const std::string& line : result->lost) print_text("lost " + line + "\n");
  if (result->lost.empty()) std::printf("nothing was lost\n");
  return {};
}

}  // namespace

Verb recover_verb() {
  const auto flags = std::make_shared<RecoverFlags>();
  Verb verb;
  verb.name = "recover";
  verb.summary = "Write what a truncated or damaged map still holds as a map of its own";
  verb.details =
      "Keeps every tile whose digest still holds and says what was lost. The result is another "
      "map: its version says \"recovered\", and no signature of the original fits it.";
  verb.examples = {"sightline recover damaged.slmap -o rest.slmap"};
  verb.positionals = {map_positional(flags->map, "The damaged map")};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(recover(*flags)); };
  return verb;
}

}  // namespace sightline
