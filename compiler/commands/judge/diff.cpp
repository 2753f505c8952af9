#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/file_kind.h"
#include "compiler/cli/result_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/views/text/map_diff_json.h"
#include "compiler/views/text/map_diff_text.h"
#include "formats/map/diff/diff_maps.h"

namespace sightline {
namespace {

// As diff(1) and every script that asks it.
constexpr int kSame = 0;
constexpr int kDifferent = 1;
constexpr int kTrouble = 2;

const std::vector<std::string> kFormats = {"text", "json", "markdown", "geojson"};

struct DiffFlags {
  std::string before;
  std::string after;
  ResultFlags result;
  std::string world;
  MapDiffOptions options;
  bool is_quiet = false;
  bool prints_all = false;
};

Result<std::string> text_of(const MapDiff& diff, const DiffFlags& flags) {
  SIGHTLINE_ASSIGN(const World world, named_world(flags.world, diff.after.world));
  const std::string format = flags.result.chosen_format(kFormats);
  if (format == "json") return to_json(diff);
  if (format == "markdown") return to_markdown(diff);
  if (format == "geojson") return to_geojson(diff, world);
  return flags.prints_all ? to_text(diff) : summary_text(diff);
}

Result<bool> diff(const DiffFlags& flags) {
  SIGHTLINE_TRY(named_world(flags.world, kLocalWorld));  // before maps are read
  SIGHTLINE_TRY(try_result(flags.result));
  SIGHTLINE_ASSIGN(const MapDiff found,
                   diff_maps(std::filesystem::path(flags.before),
                             std::filesystem::path(flags.after), flags.options));
  if (flags.is_quiet && flags.result.output.empty()) return found.is_same();
  SIGHTLINE_ASSIGN(const std::string text, text_of(found, flags));
  SIGHTLINE_TRY(put_result(flags.result, text));
  return found.is_same();
}

}  // namespace

Verb diff_verb() {
  const auto flags = std::make_shared<DiffFlags>();
  Verb verb;
  verb.name = "diff";
  verb.summary = "Show what changed between two maps: streets, ranges, promises, definitions";
  verb.details =
      "Exit status: 0 the maps are the same, 1 they differ, 2 failed (64 an unknown flag).\n\n"
      "The answer of the old map at each site of the new one is compared with the new answer. "
      "Tiles "
      "with equal digests are not read. The text is one screen; --all prints more. Use the form "
      "markdown for a pull request and geojson for a GIS; json is described in "
      "schemas/diff.schema.json.";
  verb.examples = {
      "sightline diff old.slmap new.slmap", "sightline diff old.slmap new.slmap -q || echo changed",
      "sightline diff old.slmap new.slmap --format markdown >> \"$GITHUB_STEP_SUMMARY\"",
      "sightline diff old.slmap new.slmap --format geojson --world utm:33N > changed.geojson"};
  verb.positionals = {{.name = "BEFORE", .help = "The old map (.slmap)", .target = &flags->before},
                      {.name = "AFTER", .help = "The new map (.slmap)", .target = &flags->after}};
  verb.flags = {quiet_flag(flags->is_quiet),
                {.names = "--all",
                 .help = "Print also further stretches, every limit and every changed fact",
                 .target = &flags->prints_all},
                {.names = "--tolerance-m",
                 .value = "METRES",
                 .help = "An ND whose mean moved no farther stayed",
                 .target = &flags->options.tolerance_m,
                 .minimum = 0.0},
                {.names = "--join-m",
                 .value = "METRES",
                 .help = "Largest distance along the route between changes of one stretch",
                 .target = &flags->options.join_m,
                 .minimum = 0.0},
                {.names = "--longest-m",
                 .value = "METRES",
                 .help = "A longer stretch is split into pieces",
                 .target = &flags->options.longest_m,
                 .minimum = 0.001},
                world_flag(flags->world)};
  add_result_flags(verb, flags->result, kFormats, "json as schemas/diff.schema.json describes it");
  verb.run = [flags]() -> Result<int> {
    const Result<bool> is_same = diff(*flags);
    if (!is_same) report_error(explain_wrong_file(is_same.error()));
    return !is_same ? kTrouble : *is_same ? kSame : kDifferent;
  };
  return verb;
}

}  // namespace sightline
