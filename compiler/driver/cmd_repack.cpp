#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/repack.h"
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
  const Result<MappedFile> file = MappedFile::open(flags.map);
  if (!file) return file.error();
  const Result<Repacked> result = strip_map(file->bytes());
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

void add_strip_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand(
      "strip", "Write a map without what only engineers need; no other digest changes");
  command->footer(
      "Drops the map factors and the error model. The root digest stays, and so does a signature.\n"
      "Example:\n  sightline strip town.slmap -o town.vehicle.slmap");
  const auto flags = std::make_shared<StripFlags>();
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_option("-o,--output", flags->output, "Where to write the new map")->required();
  command->add_flag("--force", flags->force, "Replace the output where it exists");
  command->callback([flags, &status] {
    const Result<void> done = strip(*flags);
    status = done ? 0 : report_error(done.error());
  });
}

}  // namespace sightline
