#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/apply_delta.h"
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
  SIGHTLINE_TRY(write_file_atomically(flags.out, delta, if_exists(flags.is_forced)));
  std::error_code ignored;
  const auto whole = std::filesystem::file_size(flags.result, ignored);
  std::fprintf(stderr, "%s: %zu bytes, %.1f %% of the new map\n", flags.out.c_str(), delta.size(),
               100.0 * static_cast<double>(delta.size()) / static_cast<double>(whole));
  return {};
}

struct ApplyFlags {
  std::string delta;
  std::string map;
  std::string out;
  bool rolls_back = false;
};

Result<void> apply(const ApplyFlags& flags) {
  if (flags.rolls_back) {
    if (!flags.delta.empty() || !flags.out.empty()) {
      return Error{ErrorCode::kBadArgument, "--rollback takes no delta and no --output"};
    }
    SIGHTLINE_ASSIGN(const Digest root, roll_back(flags.map));
    std::printf("%s is map %s again\n", flags.map.c_str(), to_hex(root).c_str());
    return {};
  }
  if (flags.delta.empty()) {
    return Error{ErrorCode::kBadArgument, "a delta is needed, or --rollback"};
  }
  SIGHTLINE_ASSIGN(const ApplyReport report,
                   flags.out.empty() ? apply_delta(flags.delta, flags.map)
                                     : apply_delta_to(flags.delta, flags.map, flags.out));
  std::printf("%s %s map %s\n", (flags.out.empty() ? flags.map : flags.out).c_str(),
              report.was_there ? "was already" : "is now", to_hex(report.root_digest).c_str());
  if (report.kept_bytes > 0) {
    std::fprintf(stderr, "%llu of %llu bytes were there from an apply that had been interrupted\n",
                 static_cast<unsigned long long>(report.kept_bytes),
                 static_cast<unsigned long long>(report.result_size));
  }
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

Verb apply_verb() {
  const auto flags = std::make_shared<ApplyFlags>();
  Verb verb;
  verb.name = "apply";
  verb.summary = "Bring a map up to date with a delta, or take it back";
  verb.details =
      "The map is the old one or the new one at every moment, also when power is lost; the same "
      "command then goes on. The old map stays beside it as MAP.previous.";
  verb.examples = {"sightline apply town-1-to-2.sldelta --to town.slmap",
                   "sightline apply --rollback --to town.slmap",
                   "sightline apply town-1-to-2.sldelta --to town-1.slmap -o town-2.slmap"};
  verb.positionals = {{.name = "DELTA",
                       .help = "The delta (.sldelta)",
                       .target = &flags->delta,
                       .is_required = false}};
  verb.flags = {{.names = "--to",
                 .value = "FILE",
                 .help = "The map to bring up to date (.slmap)",
                 .target = &flags->map,
                 .is_required = true},
                output_flag(flags->out, "Write the new map here, leave the old one alone (.slmap)"),
                {.names = "--rollback",
                 .help = "Take back the last apply",
                 .target = &flags->rolls_back,
                 .excludes = "--output"}};
  verb.run = [flags] { return exit_status_of(apply(*flags)); };
  return verb;
}

}  // namespace sightline
