#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/recover.h"
#include "formats/map/map_writer.h"
#include "formats/reader/mapped_file.h"

namespace sightline {
namespace {

struct RecoverFlags {
  std::string map;
  std::string output;
  bool force = false;
};

Result<void> recover(const RecoverFlags& flags) {
  const Result<MappedFile> file = MappedFile::open(flags.map);
  if (!file) return file.error();
  const Result<Recovered> result = recover_map(file->bytes());
  if (!result) return in_file(result.error(), flags.map);
  const Result<void> written =
      write_file_atomically(flags.output, encode_map(result->map),
                            flags.force ? IfExists::kReplace : IfExists::kRefuse);
  if (!written) return written;
  for (const std::string& line : result->lost) std::printf("lost %s\n", line.c_str());
  if (result->lost.empty()) std::printf("nothing was lost\n");
  return {};
}

}  // namespace

void add_recover_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<RecoverFlags>();
  CLI::App* command = app.add_subcommand(
      "recover", "Write what a truncated or damaged map still holds as a map of its own");
  command->footer(
      "Keeps every tile whose digest still holds and says what was lost. The result is another map:\n"
      "its version says \"recovered\", and no signature of the original fits it.\n"
      "Example:\n  sightline recover damaged.slmap -o rest.slmap");
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_option("-o,--output", flags->output, "Where to write the map of what is left")->required();
  command->add_flag("--force", flags->force, "Replace the output where it exists");
  command->callback([flags, &status] {
    const Result<void> done = recover(*flags);
    status = done ? 0 : report_error(done.error());
  });
}

}  // namespace sightline
