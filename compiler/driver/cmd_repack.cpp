#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
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

void add_flags(CLI::App& command, Repacking repacking, int& status) {
  const auto flags = std::make_shared<RepackFlags>();
  command.add_option("map", flags->map, "The map (.slmap)")->required();
  command.add_option("-o,--output", flags->output, "Where to write the new map")->required();
  command.add_flag("--force", flags->force, "Replace the output where it exists");
  command.callback([flags, repacking, &status] {
    const Result<void> done = repack(*flags, repacking);
    status = done ? 0 : report_error(done.error());
  });
}

}  // namespace

void add_strip_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand(
      "strip", "Write a map without what only engineers need; no other digest changes");
  command->footer(
      "Drops the map factors and the error model. The root digest stays, and so does a signature.\n"
      "Example:\n  sightline strip town.slmap -o town.vehicle.slmap");
  add_flags(*command, &strip_map, status);
}

void add_migrate_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand(
      "migrate", "Write a map of an older format in the format of this program");
  command->footer(
      "Each step from one format version to the next is named. Digests over the contents stay.\n"
      "Example:\n  sightline migrate old.slmap -o new.slmap");
  add_flags(*command, &migrate_map, status);
}

}  // namespace sightline
