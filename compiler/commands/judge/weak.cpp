#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/views/exports/weakness_json.h"
#include "compiler/views/text/weakness_text.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

struct WeakFlags {
  std::string map;
  std::string format = "text";
  std::string output;
  std::string world;
  WeaknessOptions options;
  double limit_m = 0.0;
  int most = 10;
  int advice = 3;
  int threads = 0;
  bool is_forced = false;
};

Result<std::string> text_of(const Weakness& weakness, const CompiledMap& map,
                            const WeakFlags& flags) {
  if (flags.format == "json") return to_json(weakness, map.sites);
  if (flags.format == "csv") return format_table(table_of(weakness, map.sites), TableFormat::kCsv);
  if (flags.format == "geojson") {
    SIGHTLINE_ASSIGN(const World world, named_world(flags.world, map.world));
    return to_geojson(weakness, map.sites, world);
  }
  return to_text(weakness, map.sites) + concat("Next: sightline report ", command_word(flags.map),
                                               " -o map.html  # shows these stretches on a page\n");
}

Result<void> weak(WeakFlags flags) {
  SIGHTLINE_TRY(named_world(flags.world, kLocalWorld));  // before the map is read
  SIGHTLINE_TRY(try_output(flags.output, if_exists(flags.is_forced)));
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.map));
  flags.options.stretches.limit_m = flags.limit_m;
  flags.options.most = static_cast<std::size_t>(flags.most);
  flags.options.advice.most = static_cast<std::size_t>(flags.advice);
  PassContext ctx;
  ctx.threads = flags.threads;
  SIGHTLINE_ASSIGN(const Weakness weakness, find_weakness(ctx, flags.options, map));
  SIGHTLINE_ASSIGN(const std::string text, text_of(weakness, map, flags));
  if (!flags.output.empty()) {
    SIGHTLINE_TRY(write_file_atomically(flags.output, text, if_exists(flags.is_forced)));
    print_written(flags.output);
    return {};
  }
  flags.format == "text" ? print_text(text) : print_data(text);
  return {};
}

}  // namespace

Verb weak_verb() {
  const auto flags = std::make_shared<WeakFlags>();
  AdviceOptions& advice = flags->options.advice;
  Verb verb;
  verb.name = "weak";
  verb.summary = "Find where a map is weak, in which direction, why, and what would help";
  verb.details =
      "Needs only the map, also one made without drives. A site is unmet if no range and no look "
      "is "
      "good enough. It is thin if the predicted error of the best one leaves less than --margin of "
      "the limit. Weak sites of a run that are near each other form one stretch. The worst "
      "stretches are listed first.\n\nFor each stretch, the least constrained direction and the "
      "cause are printed: empty (few upright surfaces in sight), one-sided (all of them face one "
      "way), repeated (the scene is nearly the same half a metre further), distant (the surfaces "
      "that constrain it are far away) or unclear. Then places beside the road are listed where "
      "one "
      "flat upright board would reduce the standard deviation of that direction most. The board is "
      "simulated: its returns, the beams that it stops, and its NDs in the map. The gain ranks "
      "places; a later drive can measure another gain.\n\nThe map has no lanes. A place for a "
      "board "
      "is on known, free ground at a distance from the driven line, and may be in another lane.";
  verb.examples = {
      "sightline weak town.slmap",
      "sightline weak town.slmap --margin 0.7 --board-width 2        # more stretches, larger "
      "boards",
      "sightline weak town.slmap --format geojson -o weak.geojson    # lines and points for QGIS",
      "sightline weak town.slmap --format csv                        # a row for each stretch"};
  verb.positionals = {map_positional(flags->map, "The map")};
  verb.flags = {
      {.names = "--limit",
       .value = "METRES",
       .help = "One of the map's limits; 0: the tightest",
       .target = &flags->limit_m,
       .minimum = 0.0},
      {.names = "--margin",
       .value = "SHARE",
       .help =
           "Least distance between predicted error and limit, as a share of the limit: with 0.5 "
           "and a limit of 10 cm, sites with a predicted error above 5 cm are weak; 0: only "
           "errors above the limit, 1: every site; unmet sites always",
       .target = &flags->options.stretches.least_margin,
       .minimum = 0.0,
       .maximum = 1.0},
      {.names = "--join-m",
       .value = "METRES",
       .help = "Largest distance along the route between weak sites of one stretch",
       .target = &flags->options.stretches.join_m,
       .minimum = 0.0},
      {.names = "--longest-m",
       .value = "METRES",
       .help = "A longer stretch is split into pieces of at most this length",
       .target = &flags->options.stretches.longest_m,
       .minimum = 0.001},
      {.names = "--most",
       .value = "COUNT",
       .help = "Stretches to explain, the worst ones",
       .target = &flags->most,
       .minimum = 1,
       .maximum = 1000},
      {.names = "--places",
       .value = "COUNT",
       .help = "Places for a board to list for each stretch; 0: none is simulated",
       .target = &flags->advice,
       .minimum = 0,
       .maximum = 20},
      {.names = "--board-width",
       .value = "METRES",
       .help = "Width of the board",
       .target = &advice.size.width_m,
       .minimum = 0.1,
       .maximum = 20.0},
      {.names = "--board-height",
       .value = "METRES",
       .help = "Height of the board, whose lower edge is half a metre above the ground",
       .target = &advice.size.height_m,
       .minimum = 0.1,
       .maximum = 20.0},
      {.names = "--nearest",
       .value = "METRES",
       .help = "Least distance of a board from the driven line",
       .target = &advice.nearest_m,
       .minimum = 1.0,
       .maximum = 50.0},
      {.names = "--farthest",
       .value = "METRES",
       .help = "Largest distance of a board from the driven line",
       .target = &advice.farthest_m,
       .minimum = 1.0,
       .maximum = 50.0},
      {.names = "--format",
       .value = "FORMAT",
       .help = "Form of the output; json as schemas/weak.schema.json describes it",
       .target = &flags->format,
       .choices = {"text", "csv", "json", "geojson"}},
      output_flag(flags->output, "Write to this file instead of stdout"),
      force_flag(flags->is_forced),
      world_flag(flags->world),
      threads_flag(flags->threads)};
  verb.run = [flags] { return exit_status_of(weak(*flags)); };
  return verb;
}

}  // namespace sightline
