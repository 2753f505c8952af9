#include "compiler/commands/map/export_answers.h"

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/views/exports/cells.h"
#include "compiler/views/exports/lanelet2.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

// For the localizer whose errors the map contains; the export names it.
Result<MapReader> open_for_its_own(const std::string& file) {
  SIGHTLINE_ASSIGN(const MapReader unnamed, MapReader::open(file, ""));
  return MapReader::open(file, unnamed.info().localizer);
}

void print_outside(const std::string& lanes, const Lanelet2Export& made) {
  constexpr std::size_t kMostNamed = 20;
  if (made.outside.empty()) return;
  std::string ids;
  for (std::size_t i = 0; i < made.outside.size() && i < kMostNamed; ++i) {
    ids += " " + made.outside[i];
  }
  if (made.outside.size() > kMostNamed) ids += " ...";
  print_warning(concat(lanes, ": ", made.outside.size(), " of ", made.lanelet_count,
                       " lanelets are outside the map and have observation_known=0:", ids));
}

Result<void> export_lanelet2(const std::string& map_file, const ExportAnswersFlags& flags) {
  if (flags.lanes.empty()) {
    return Error{ErrorCode::kBadArgument,
                 "--format lanelet2 annotates a Lanelet2 map: name it, --lanes lanelet2_map.osm",
                 map_file};
  }
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(map_file));
  SIGHTLINE_ASSIGN(const World world, named_world(flags.world, map.world));
  SIGHTLINE_ASSIGN(const MapReader reader, open_for_its_own(map_file));
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(flags.lanes));
  Result<Lanelet2Export> made =
      to_lanelet2(map, reader, world, text, {flags.area_limit_m, flags.weak_margin});
  if (!made) return in_file(made.error(), flags.lanes);
  SIGHTLINE_TRY(write_file_atomically(flags.output, made->text, if_exists(flags.is_forced)));
  print_outside(flags.lanes, *made);
  print_note(concat(flags.output, ": ", made->lanelet_count, " lanelets, ", made->area_count,
                    " degenerate areas and ", made->weak_area_count, " weak areas"));
  return {};
}

Result<void> export_cells(const std::string& map_file, const ExportAnswersFlags& flags) {
  SIGHTLINE_ASSIGN(const MapReader reader, open_for_its_own(map_file));
  SIGHTLINE_ASSIGN(const Table cells, answers_by_cell(reader, flags.cell_m));
  return write_file_atomically(flags.output, format_table(cells, TableFormat::kCsv),
                               if_exists(flags.is_forced));
}

}  // namespace

const std::string_view kLanelet2Details =
    "\n\n"
    "lanelet2 keeps every byte of the file of lanes and adds tags to each lanelet, for each limit "
    "(010 is 0.10 m): observation_range_010 (m, the longest range of its places), _p95 (enough at "
    "95 % of its places), _least, _unmet (share of places where no range is good enough); "
    "observation_look_010_range, _returns, _points, _even_beyond, _by_normals, _settles (the most "
    "expensive look of its places), _unmet; observation_known (share of places with an answer); "
    "observation_localizer. Far from sites the value is unknown. Where the limit --area-limit is "
    "unmet, an area of type degenerate_area and subtype feature_poor_road is added, which "
    "Autoware's environment adaptor reads. Where it is met but "
    "`sightline weak` lists the place for that limit, the subtype is feature_weak_road.";

void add_answers_flags(Verb& verb, ExportAnswersFlags& flags) {
  verb.flags.push_back({.names = "--lanes",
                        .value = "FILE",
                        .help = "For lanelet2: the Lanelet2 map (.osm) to annotate",
                        .target = &flags.lanes});
  verb.flags.push_back(
      {.names = "--area-limit",
       .value = "METRES",
       .help =
           "For lanelet2: the limit of the map whose unmet stretches become areas; default: the "
           "widest",
       .target = &flags.area_limit_m,
       .minimum = 0.001});
  verb.flags.push_back({.names = "--weak-margin",
                        .value = "SHARE",
                        .help =
                            "For lanelet2: a stretch becomes a weak area where the predicted error "
                            "of the best look leaves less than this share of that limit; 0: only "
                            "where the error exceeds it",
                        .target = &flags.weak_margin,
                        .minimum = 0.0,
                        .maximum = 1.0});
  verb.flags.push_back({.names = "--cell",
                        .value = "METRES",
                        .help = "For cells: edge of the cells of the grid",
                        .target = &flags.cell_m,
                        .minimum = 0.5,
                        .maximum = 100.0});
}

bool asks_the_reader(std::string_view format) { return format == "lanelet2" || format == "cells"; }

Result<void> export_answers(std::string_view format, const std::string& map_file,
                            const ExportAnswersFlags& flags) {
  return format == "cells" ? export_cells(map_file, flags) : export_lanelet2(map_file, flags);
}

}  // namespace sightline
