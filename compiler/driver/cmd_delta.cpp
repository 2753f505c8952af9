#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/make_delta.h"

namespace sightline {
namespace {

struct DeltaFlags {
  std::string base;
  std::string result;
  std::string out;
  DeltaOptions options;
  bool is_forced = false;
};

Result<void> write_delta(const DeltaFlags& flags) {
  const Result<std::vector<std::byte>> delta =
      make_delta(std::filesystem::path(flags.base), std::filesystem::path(flags.result),
                 flags.options);
  if (!delta) return delta.error();
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  const Result<void> written = write_file_atomically(flags.out, *delta, if_exists);
  if (!written) return written;
  std::error_code ignored;
  const auto whole = std::filesystem::file_size(flags.result, ignored);
  std::fprintf(stderr, "%s: %zu bytes, %.1f %% of the new map\n", flags.out.c_str(), delta->size(),
               100.0 * static_cast<double>(delta->size()) / static_cast<double>(whole));
  return {};
}

}  // namespace

void add_delta_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<DeltaFlags>();
  CLI::App* command = app.add_subcommand(
      "delta", "Write what a vehicle with one map needs to have another: changed layers alone");
  command->footer(
      "Both maps are checked first. The delta belongs to these two maps: apply refuses any other.\n\n"
      "Examples:\n"
      "  sightline delta town-1.slmap town-2.slmap -o town-1-to-2.sldelta\n"
      "  sightline apply town-1-to-2.sldelta --to town.slmap");
  command->add_option("base", flags->base, "The map that vehicles have (.slmap)")->required();
  command->add_option("new", flags->result, "The map that they shall have (.slmap)")->required();
  command->add_option("-o,--out", flags->out, "The delta to write (.sldelta)")->required();
  command->add_flag("--portable", flags->options.is_portable,
                    "For vehicles with another version of zstd than this program: larger");
  command->add_flag("--force", flags->is_forced, "Replace an existing delta");
  command->callback([flags, &status] {
    const Result<void> written = write_delta(*flags);
    status = written ? 0 : report_error(written.error());
  });
}

}  // namespace sightline
