#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/make_delta.h"
#include "formats/text/numbers.h"

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
  const double share = static_cast<double>(delta.size()) / static_cast<double>(whole);
  print_written(flags.out, in_percent(share) + " % of the new map");
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
      return Error{ErrorCode::kBadArgument,
                   "--rollback is used without a delta and without --output"};
    }
    SIGHTLINE_ASSIGN(const Digest root, roll_back(flags.map));
    print_written(flags.map, "map " + to_hex(root) + " again");
    return {};
  }
  if (flags.delta.empty()) {
    return Error{ErrorCode::kBadArgument, "name a delta, or use --rollback"};
  }
  SIGHTLINE_ASSIGN(const ApplyReport report,
                   flags.out.empty() ? apply_delta(flags.delta, flags.map)
                                     : apply_delta_to(flags.delta, flags.map, flags.out));
  const std::string& file = flags.out.empty() ? flags.map : flags.out;
  const std::string digest = to_hex(report.root_digest);
  if (report.was_there) {
    print_text(concat(file, " is already map ", digest, "\n"));
  } else {
    print_written(file, "map " + digest);
  }
  if (report.kept_bytes > 0) {
    print_note(concat(report.kept_bytes, " of ", report.result_size,
                      " bytes were reused from an interrupted apply"));
  }
  return {};
}

}  // namespace

Verb delta_verb() {
  const auto flags = std::make_shared<DeltaFlags>();
  Verb verb;
  verb.name = "delta make";
  verb.summary = "Write the difference between two maps: only changed layers";
  verb.details =
      "Both maps are checked first. The delta fits only these two maps; `delta apply` refuses "
      "others.";
  verb.examples = {"sightline delta make town-1.slmap town-2.slmap -o town-1-to-2.sldelta",
                   "sightline delta apply town-1-to-2.sldelta --to town.slmap"};
  verb.positionals = {
      {.name = "BASE", .help = "The map that vehicles have (.slmap)", .target = &flags->base},
      {.name = "NEW", .help = "The map that vehicles get (.slmap)", .target = &flags->result}};
  verb.flags = {
      required_output_flag(flags->out, "The delta to write (.sldelta)"),
      force_flag(flags->is_forced),
      {.names = "--portable",
       .help = "Larger, for vehicles whose version of zstd differs from that of this program",
       .target = &flags->options.is_portable}};
  verb.run = [flags] { return exit_status_of(write_delta(*flags)); };
  return verb;
}

Verb apply_verb() {
  const auto flags = std::make_shared<ApplyFlags>();
  Verb verb;
  verb.name = "delta apply";
  verb.summary = "Update a map with a delta, or undo the update";
  verb.details =
      "At every moment the file is the complete old map or the complete new one, also if power "
      "fails; the same command then continues. The old map is kept beside it as MAP.previous.";
  verb.examples = {"sightline delta apply town-1-to-2.sldelta --to town.slmap",
                   "sightline delta apply --rollback --to town.slmap",
                   "sightline delta apply town-1-to-2.sldelta --to town-1.slmap -o town-2.slmap"};
  verb.positionals = {{.name = "DELTA",
                       .help = "The delta (.sldelta)",
                       .target = &flags->delta,
                       .is_required = false}};
  verb.flags = {
      {.names = "--to",
       .value = "FILE",
       .help = "The map to update (.slmap)",
       .target = &flags->map,
       .is_required = true},
      output_flag(flags->out, "Write the new map to this file and keep the old one (.slmap)"),
      {.names = "--rollback",
       .help = "Undo the last update",
       .target = &flags->rolls_back,
       .excludes = "--output"}};
  verb.run = [flags] { return exit_status_of(apply(*flags)); };
  return verb;
}

}  // namespace sightline
