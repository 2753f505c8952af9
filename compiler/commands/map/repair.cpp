#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "formats/map/repair/repair.h"
#include "formats/reader/mapped_file.h"

// Verbs that write a map again without computing anything.

namespace sightline {
namespace {

struct RepairFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> strip(const RepairFlags& flags) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(flags.map));
  const Result<Repacked> result = strip_map(file.bytes());
  if (!result) return in_file(result.error(), flags.map);
  SIGHTLINE_TRY(write_file_atomically(flags.output, result->file, if_exists(flags.force)));
  print_written(flags.output, concat("was ", size_text(file.bytes().size())));
  for (const std::string& line : result->actions) print_note(line);
  return {};
}

Result<void> recover(const RepairFlags& flags) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(flags.map));
  const Result<Recovered> result = recover_map(file.bytes());
  if (!result) return in_file(result.error(), flags.map);
  SIGHTLINE_TRY(
      write_file_atomically(flags.output, encode_map(result->map), if_exists(flags.force)));
  const std::size_t count = result->lost.size();
  print_written(flags.output, count == 0 ? "nothing was lost"
                                         : concat(count, " parts were lost, see the warnings"));
  for (const std::string& line : result->lost) print_warning("lost " + line);
  return {};
}

}  // namespace

Verb strip_verb() {
  const auto flags = std::make_shared<RepairFlags>();
  Verb verb;
  verb.name = "strip";
  verb.summary = "Write a map without the parts that vehicles do not need";
  verb.details =
      "Removes the map factors, the error model and the sketches of the recordings' scans. The "
      "root digest is unchanged, so signatures stay valid. A map compiled with "
      "emit-map.size=promise is then about a fifth as large.";
  verb.examples = {"sightline strip town.slmap -o town.vehicle.slmap"};
  verb.positionals = {map_positional(flags->map, "The map to read")};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(strip(*flags)); };
  return verb;
}

Verb recover_verb() {
  const auto flags = std::make_shared<RepairFlags>();
  Verb verb;
  verb.name = "recover";
  verb.summary = "Write the intact parts of a truncated or damaged map as a new map";
  verb.details =
      "Keeps every tile whose digest is right and lists the lost parts. The result is a different "
      "map: its version contains \"recovered\", and signatures of the original are not valid for "
      "it.";
  verb.examples = {"sightline recover damaged.slmap -o rest.slmap"};
  verb.positionals = {map_positional(flags->map, "The damaged map")};
  verb.flags = {required_output_flag(flags->output, "The map to write (.slmap)"),
                force_flag(flags->force)};
  verb.run = [flags] { return exit_status_of(recover(*flags)); };
  return verb;
}

}  // namespace sightline
