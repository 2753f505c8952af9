#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/make_delta.h"

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
  SIGHTLINE_ASSIGN(const std::vector<std::byte> delta,
                   make_delta(std::filesystem::path(flags.base),
                              std::filesystem::path(flags.result), flags.options));
  const IfExists if_exists = flags.is_forced ? IfExists::kReplace : IfExists::kRefuse;
  SIGHTLINE_TRY(write_file_atomically(flags.out, delta, if_exists));
  std::error_code ignored;
  const auto whole = std::filesystem::file_size(flags.result, ignored);
  std::fprintf(stderr, "%s: %zu bytes, %.1f %% of the new map\n", flags.out.c_str(), delta.size(),
               100.0 * static_cast<double>(delta.size()) / static_cast<double>(whole));
  return {};
}

}  // namespace

Verb delta_verb() {
  const auto flags = std::make_shared<DeltaFlags>();
  Verb verb;
  verb.name = "delta";
  verb.summary = "Write what turns one map into another: changed layers alone";
  verb.details =
      "Both maps are checked first. The delta belongs to these two maps: apply refuses any other.";
  verb.examples = {"sightline delta town-1.slmap town-2.slmap -o town-1-to-2.sldelta",
                   "sightline apply town-1-to-2.sldelta --to town.slmap"};
  verb.positionals = {
      {.name = "BASE", .help = "The map that vehicles have (.slmap)", .target = &flags->base},
      {.name = "NEW", .help = "The map that they shall have (.slmap)", .target = &flags->result}};
  verb.flags = {required_output_flag(flags->out, "The delta to write (.sldelta)"),
                force_flag(flags->is_forced),
                {.names = "--portable",
                 .help = "For vehicles with another version of zstd than this program: larger",
                 .target = &flags->options.is_portable}};
  verb.run = [flags] { return exit_status_of(write_delta(*flags)); };
  return verb;
}

}  // namespace sightline
