#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/diff_maps.h"
#include "formats/map/map_diff_json.h"
#include "formats/map/map_diff_text.h"

namespace sightline {
namespace {

// As diff(1) and every script that asks it.
constexpr int kSame = 0;
constexpr int kDifferent = 1;
constexpr int kTrouble = 2;

struct DiffFlags {
  std::string before;
  std::string after;
  std::string format = "text";
  std::string world = "local";
  MapDiffOptions options;
  bool is_quiet = false;
};

Result<std::string> text_of(const MapDiff& diff, const std::string& format, const World& world) {
  if (format == "json") return to_json(diff);
  if (format == "markdown") return to_markdown(diff);
  if (format == "geojson") return to_geojson(diff, world);
  return to_text(diff);
}

Result<bool> diff(const DiffFlags& flags) {
  const Result<World> world = parse_world(flags.world);
  if (!world) return world.error();
  const Result<MapDiff> found = diff_maps(std::filesystem::path(flags.before),
                                          std::filesystem::path(flags.after), flags.options);
  if (!found) return found.error();
  if (!flags.is_quiet) {
    const Result<std::string> text = text_of(*found, flags.format, *world);
    if (!text) return text.error();
    std::fputs(text->c_str(), stdout);
  }
  return found->is_same();
}

}  // namespace

void add_diff_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<DiffFlags>();
  CLI::App* command = app.add_subcommand(
      "diff", "Tell what changed between two maps: streets, ranges, promises, definitions");
  command->footer(
      "Exit status: 0 the maps are the same, 1 they differ, 2 trouble (64 an unknown flag).\n\n"
      "Sites are matched by place: the old map is asked where each site of the new one lies, as a\n"
      "vehicle would ask. Tiles with equal digests are not read.\n\n"
      "Examples:\n"
      "  sightline diff old.slmap new.slmap\n"
      "  sightline diff old.slmap new.slmap -q || echo changed\n"
      "  sightline diff old.slmap new.slmap --format markdown >> \"$GITHUB_STEP_SUMMARY\"\n"
      "  sightline diff old.slmap new.slmap --format geojson --world utm:33N > changed.geojson");
  command->add_option("before", flags->before, "The old map (.slmap)")->required();
  command->add_option("after", flags->after, "The new map (.slmap)")->required();
  command->add_option("--format", flags->format, "text, json (schemas/diff.schema.json), markdown "
                                                 "for a pull request, geojson for a GIS")
      ->check(CLI::IsMember({"text", "json", "markdown", "geojson"}))
      ->capture_default_str();
  command->add_flag("-q,--quiet", flags->is_quiet, "Print nothing, the exit status tells");
  command->add_option("--tolerance-m", flags->options.tolerance_m,
                      "An ND whose mean moved no farther stayed, m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--join-m", flags->options.join_m,
                      "Changes along the route no farther apart are told as one stretch, m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--longest-m", flags->options.longest_m,
                      "A longer stretch is told in pieces, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--world", flags->world,
                   "Where the maps' coordinates lie, for geojson: local, utm:ZONE (utm:32N) or "
                   "enu:LATITUDE,LONGITUDE,ALTITUDE")
      ->capture_default_str();
  command->callback([flags, &status] {
    const Result<bool> is_same = diff(*flags);
    if (!is_same) report_error(is_same.error());
    status = !is_same ? kTrouble : *is_same ? kSame : kDifferent;
  });
}

}  // namespace sightline
