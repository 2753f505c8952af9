#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/cli/common_flags.h"
#include "compiler/driver/commands.h"
#include "formats/map/repack.h"
#include "formats/reader/mapped_file.h"

// The verbs that write a map anew without computing anything: strip and migrate.

namespace sightline {
namespace {

using Repacking = Result<Repacked> (*)(std::span<const std::byte> file);

struct RepackFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> repack(const RepackFlags& flags, Repacking repacking) {
  const Result<MappedFile> file = MappedFile::open(flags.map);
  if (!file) return file.error();
  const Result<Repacked> result = repacking(file->bytes());
  if (!result) return in_file(result.error(), flags.map);
  const Result<void> written =
      write_file_atomically(flags.output, result->file,
                            flags.force ? IfExists::kReplace : IfExists::kRefuse);
  if (!written) return written;
  for (const std::string& line : result->told) std::printf("%s\n", line.c_str());
  std::printf("%zu bytes, were %zu\n", result->file.size(), file->bytes().size());
  return {};
}

Verb repacking_verb(Repacking repacking) {
  const auto flags = std::make_shared<RepackFlags>();
  Verb verb;
  verb.positionals = {map_positional(flags->map, "The map to read")};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->force)};
  verb.run = [flags, repacking] { return exit_status_of(repack(*flags, repacking)); };
  return verb;
}

}  // namespace

Verb strip_verb() {
  Verb verb = repacking_verb(&strip_map);
  verb.name = "strip";
  verb.summary = "Write a map without what only engineers need; no other digest changes";
  verb.details =
      "Drops the map factors and the error model. The root digest stays, and so does a signature.";
  verb.examples = {"sightline strip town.slmap -o town.vehicle.slmap"};
  return verb;
}

Verb migrate_verb() {
  Verb verb = repacking_verb(&migrate_map);
  verb.name = "migrate";
  verb.summary = "Write a map of an older format in the format of this program";
  verb.details =
      "Each step from one format version to the next is named. Digests over the contents stay.";
  verb.examples = {"sightline migrate old.slmap -o new.slmap"};
  return verb;
}

}  // namespace sightline
