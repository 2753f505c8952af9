#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/repack.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

struct MigrateFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> migrate(const MigrateFlags& flags) {
  const Result<MappedFile> file = MappedFile::open(flags.map);
  if (!file) return file.error();
  const Result<Repacked> result = migrate_map(file->bytes());
  if (!result) return in_file(result.error(), flags.map);
  const Result<void> written =
      write_file_atomically(flags.output, result->file,
                            flags.force ? IfExists::kReplace : IfExists::kRefuse);
  if (!written) return written;
  for (const std::string& line : result->told) std::printf("%s\n", line.c_str());
  std::printf("%zu bytes, were %zu\n", result->file.size(), file->bytes().size());
  return {};
}

}  // namespace

void add_migrate_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<MigrateFlags>();
  CLI::App* command = app.add_subcommand(
      "migrate", "Write a map of an older format in the format of this program");
  command->footer(
      "Each step from one format version to the next is named. Digests over the contents stay.\n"
      "Example:\n  sightline migrate old.slmap -o new.slmap");
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_option("-o,--output", flags->output, "Where to write the new map")->required();
  command->add_flag("--force", flags->force, "Replace the output where it exists");
  command->callback([flags, &status] {
    const Result<void> done = migrate(*flags);
    status = done ? 0 : report_error(done.error());
  });
}

}  // namespace sightline
