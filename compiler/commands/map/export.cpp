#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <span>
#include <utility>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/map/export_answers.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/exports/autoware.h"
#include "compiler/views/exports/export_frame.h"
#include "compiler/views/exports/foxglove_mcap.h"
#include "compiler/views/exports/geojson.h"
#include "compiler/views/exports/geopackage.h"
#include "compiler/views/exports/octomap.h"
#include "compiler/views/exports/ply.h"
#include "compiler/views/text/table_rows.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "passes/map/remove_moving.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct ExportFlags {
  RunFlags run;  // config_file is the target: a map or a configuration
  std::string format;
  ExportAnswersFlags answers;
  double leaf_m = 0.2;

  [[nodiscard]] bool is_map() const { return fs::path(run.config_file).extension() == ".slmap"; }
  [[nodiscard]] IfExists if_exists() const { return sightline::if_exists(answers.is_forced); }
};

// What made the map, from the configuration that did: no map carries it.
Result<SurfacePoints> surface_of(const ExportFlags& flags, const CompileConfig& config) {
  if (config.map.is_compiled) {
    return Error{ErrorCode::kBadArgument,
                 "a compiled map contains NDs and no points; export the map itself",
                 config.map.points};
  }
  const CompilePlan compile = compile_plan(config);
  if (!compile.points.is_connected()) {
    return Error{ErrorCode::kBadArgument, "the map contains NDs and no points", config.map.points};
  }
  SIGHTLINE_TRY(check_stop(flags.run, compile.plan, {compile.points}));
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(flags.run), artifacts));
  SIGHTLINE_TRY(run_steps(compile.plan, {compile.points}, flags.run, config, artifacts));
  return artifacts.get(compile.points);
}

std::vector<PointXyzi> means_of(const NdtMap& ndt) {
  const Eigen::Vector3d shift_m = export_shift_m(ndt.frame);
  std::vector<PointXyzi> points;
  for (const Nd& nd : ndt.nds) {
    const Eigen::Vector3f p_m = (nd.mean_m + shift_m).cast<float>();
    points.push_back({p_m.x(), p_m.y(), p_m.z(), static_cast<float>(nd.point_count)});
  }
  return points;
}

// Some rows at a time: the text of a long street is as large as its table. Takes the rows.
Result<void> write_rows(Table table, const ByteSink& sink) {
  constexpr std::size_t kRowsAtOnce = 4096;
  Table piece{table.name, table.columns, {}, {}};
  const std::string head = format_table(piece, TableFormat::kCsv);
  SIGHTLINE_TRY(sink(std::as_bytes(std::span(head))));
  for (std::size_t first = 0; first < table.rows.size(); first += kRowsAtOnce) {
    const std::size_t count = std::min(kRowsAtOnce, table.rows.size() - first);
    const auto begin = table.rows.begin() + static_cast<std::ptrdiff_t>(first);
    piece.rows.assign(std::make_move_iterator(begin),
                      std::make_move_iterator(begin + static_cast<std::ptrdiff_t>(count)));
    const std::string text = format_table(piece, TableFormat::kCsv);
    SIGHTLINE_TRY(sink(std::as_bytes(std::span(text)).subspan(head.size())));
  }
  return {};
}

// A table whose first line names its columns; facts of the whole table are added to `facts`.
Result<void> export_rows(const ExportFlags& flags, Table table, Table& facts) {
  for (const auto& [fact, value] : table.facts) facts.rows.push_back({table.name, fact, value});
  const fs::path file = fs::path(flags.answers.output) / (table.name + ".csv");
  const auto write = [&](const ByteSink& sink) { return write_rows(std::move(table), sink); };
  return write_file_atomically(file, write, flags.if_exists());
}

Result<void> export_tables(const ExportFlags& flags, const CompiledMap& map, const World& world) {
  Table facts{"facts", {"table", "name", "value"}, {}, {}};
  for (const std::string& name : dump_names()) {
    if (name == "model" || (name == "factors" && map.factors.factors.empty())) continue;
    if (name == "tile-drives" && !map.tile_drives) continue;
    if (name == "columns" && map.columns.empty()) continue;
    SIGHTLINE_ASSIGN(Table table, dump(map, name));
    table.name = name;
    to_world(map.ndt.frame, table);
    if (name == "sites") {
      SIGHTLINE_TRY(add_degrees(map.sites, world, table));
    }
    const bool has_looks =
        map.looks.has_value() && std::ranges::find(table.columns, "look") != table.columns.end();
    Table samples;
    if (has_looks) samples = take_samples(table);
    keep_looks(KeptLooks::kRanges, table);
    SIGHTLINE_TRY(export_rows(flags, std::move(table), facts));
    if (has_looks) {
      SIGHTLINE_TRY(export_rows(flags, std::move(samples), facts));
    }
  }
  return write_file_atomically(fs::path(flags.answers.output) / "facts.csv",
                               format_table(facts, TableFormat::kCsv), flags.if_exists());
}

Result<void> export_map(const ExportFlags& flags) {
  if (asks_the_reader(flags.format)) {
    return export_answers(flags.format, flags.run.config_file, flags.answers);
  }
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.run.config_file));
  SIGHTLINE_ASSIGN(const World world, named_world(flags.answers.world, map.world));
  if (flags.format == "csv") return export_tables(flags, map, world);
  if (flags.format == "gpkg") {
    SIGHTLINE_ASSIGN(const std::vector<std::byte> package, to_geopackage(map, world));
    return write_file_atomically(flags.answers.output, package, flags.if_exists());
  }
  if (flags.format == "mcap") {
    const auto write = [&](const ByteSink& sink) { return write_foxglove_mcap(map, world, sink); };
    return write_file_atomically(flags.answers.output, write, flags.if_exists());
  }
  if (flags.format == "pcd") {
    return write_pcd_binary(flags.answers.output, means_of(map.ndt), flags.if_exists());
  }
  if (flags.format == "ply") {
    const auto write = [&](const ByteSink& sink) { return write_nd_gaussians(map.ndt, sink); };
    return write_file_atomically(flags.answers.output, write, flags.if_exists());
  }
  if (flags.format == "geojson") {
    SIGHTLINE_ASSIGN(const std::string json, to_geojson(map, world));
    return write_file_atomically(flags.answers.output, json, flags.if_exists());
  }
  return Error{
      ErrorCode::kBadArgument,
      concat("--format ", flags.format,
             " needs the scans of the drive, which maps do not contain: export the configuration "
             "that compiled it"),
      flags.run.config_file};
}

Result<void> write_autoware(const ExportFlags& flags, const AutowareMap& map) {
  const fs::path folder = flags.answers.output;
  for (const AutowareSquare& square : map.squares) {
    SIGHTLINE_TRY(write_pcd_binary(folder / "pointcloud_map.pcd" / square.file, square.points,
                                   flags.if_exists()));
  }
  SIGHTLINE_TRY(write_file_atomically(folder / "map_projector_info.yaml", map.projector_yaml,
                                      flags.if_exists()));
  // Last: a loader that finds it finds all that it names.
  return write_file_atomically(folder / "pointcloud_map_metadata.yaml", map.metadata_yaml,
                               flags.if_exists());
}

Result<void> write_octomap(const ExportFlags& flags, const CompileConfig& config,
                           const SurfacePoints& surface) {
  SIGHTLINE_ASSIGN(
      const std::vector<std::byte> tree,
      octomap_bt(surface, {flags.leaf_m, config.passes.options(kRemoveMoving).carve_range_m,
                           flags.run.threads}));
  if (!octomap_frame(surface.frame, flags.leaf_m).is_of_exports) {
    std::fprintf(
        stderr,
        "%s: voxels of %g m cannot represent coordinates this far from the world's origin: "
        "the octree is in map coordinates, as its header states\n",
        flags.answers.output.c_str(), flags.leaf_m);
  }
  return write_file_atomically(flags.answers.output, tree, flags.if_exists());
}

// Squares of an earlier export would be read as part of this one.
Result<void> check_folder(const ExportFlags& flags) {
  std::error_code failure;
  const bool is_used =
      fs::exists(flags.answers.output, failure) && !fs::is_empty(flags.answers.output, failure);
  if (!is_used) return {};
  return Error{ErrorCode::kOutputExists,
               "the folder is not empty, and a map directory needs an empty one; name another",
               flags.answers.output};
}

Result<void> export_points(const ExportFlags& flags) {
  const bool needs_map = flags.format == "csv" || flags.format == "geojson" ||
                         flags.format == "gpkg" || flags.format == "mcap" ||
                         asks_the_reader(flags.format);
  if (needs_map) {
    return Error{ErrorCode::kBadArgument,
                 concat("--format ", flags.format, " needs a map (.slmap)"), flags.run.config_file};
  }
  if (flags.format == "autoware") {
    SIGHTLINE_TRY(check_folder(flags));
  }
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  if (config.has_map() && flags.format == "octomap") {
    return Error{
        ErrorCode::kBadArgument,
        "--format octomap needs a drive: a finished map does not contain the sensor positions of "
        "its points",
        flags.run.config_file};
  }
  SIGHTLINE_ASSIGN(const World world, named_world(flags.answers.world, config.annotation.world));
  SIGHTLINE_ASSIGN(const SurfacePoints surface, surface_of(flags, config));
  if (flags.format == "octomap") return write_octomap(flags, config, surface);
  SIGHTLINE_ASSIGN(std::vector<Eigen::Vector3d> points, thinned_points(surface, flags.leaf_m));
  if (flags.format == "autoware") {
    SIGHTLINE_ASSIGN(const AutowareMap map, autoware_map(points, surface.frame, world));
    return write_autoware(flags, map);
  }
  const Eigen::Vector3d shift_m = export_shift_m(surface.frame);
  for (Eigen::Vector3d& point_m : points) point_m += shift_m;
  if (flags.format == "ply") {
    return write_file_atomically(flags.answers.output, points_ply(points), flags.if_exists());
  }
  std::vector<PointXyzi> written;
  for (const Eigen::Vector3d& point_m : points) {
    const Eigen::Vector3f p_m = point_m.cast<float>();
    written.push_back({p_m.x(), p_m.y(), p_m.z(), 0.0F});
  }
  return write_pcd_binary(flags.answers.output, written, flags.if_exists());
}

using Pairs = std::vector<std::pair<std::string, std::string>>;

// Formats by the ending of their files.
const Pairs& endings() {
  static const Pairs kEndings = {
      {".gpkg", "gpkg"},    {".geojson", "geojson"}, {".json", "geojson"},
      {".osm", "lanelet2"}, {".csv", "cells"},       {".pcd", "pcd"},
      {".ply", "ply"},      {".bt", "octomap"},      {".mcap", "mcap"}};
  return kEndings;
}

// Formats that other programs make of ours.
const Pairs& conversions() {
  const std::string vectors = "is not written; export gpkg, then convert it with ogr2ogr: `";
  const std::string points = "is not written; export pcd, then convert it with PDAL: `";
  static const Pairs kConversions = {
      {"kml", vectors + "ogr2ogr -f KML route.kml route.gpkg`"},
      {"kmz", vectors + "ogr2ogr -f LIBKML route.kmz route.gpkg`"},
      {"shp", vectors + "ogr2ogr -f 'ESRI Shapefile' route.shp route.gpkg`"},
      {"dxf", vectors + "ogr2ogr -f DXF route.dxf route.gpkg`"},
      {"las", points + "pdal translate map.pcd map.las`"},
      {"laz", points + "pdal translate map.pcd map.laz`"}};
  return kConversions;
}

const std::string* found_in(const Pairs& pairs, const std::string& name) {
  const auto found = std::ranges::find(pairs, name, &Pairs::value_type::first);
  return found == pairs.end() ? nullptr : &found->second;
}

// By the ending of the output; a path without one is a folder. Error: bad-argument.
Result<std::string> format_of_ending(const ExportFlags& flags) {
  const std::string ending = fs::path(flags.answers.output).extension().string();
  if (ending.empty()) return std::string(flags.is_map() ? "csv" : "autoware");
  if (const std::string* const format = found_in(endings(), ending)) return *format;
  if (const std::string* const remedy = found_in(conversions(), ending.substr(1))) {
    return Error{ErrorCode::kBadArgument, concat("'", ending, "' ", *remedy)};
  }
  std::string known;
  for (const auto& [each, format] : endings()) known += concat(" ", each, " (", format, ")");
  return Error{ErrorCode::kBadArgument,
               concat("the ending '", ending, "' names no format; known endings:", known,
                      ", and a folder (csv, autoware); --format names one")};
}

void print_exported(const fs::path& output) {
  std::error_code failure;
  if (!fs::is_directory(output, failure)) return print_written(output);
  std::size_t count = 0;
  std::uintmax_t bytes = 0;
  for (fs::recursive_directory_iterator entry(output, failure), end; entry != end;
       entry.increment(failure)) {
    if (failure || !entry->is_regular_file(failure)) continue;
    ++count;
    bytes += entry->file_size(failure);
  }
  if (verbosity() == Verbosity::kQuiet) return;
  print_text(concat("Wrote ", output.string(), " (", size_text(bytes), "): ", count, " files\n"));
}

Result<void> run_export(ExportFlags& flags) {
  if (flags.format.empty()) {
    SIGHTLINE_ASSIGN(flags.format, format_of_ending(flags));
  }
  SIGHTLINE_TRY(named_world(flags.answers.world, kLocalWorld));  // before anything is read
  if (flags.format == "autoware" || flags.format == "csv") {
    SIGHTLINE_TRY(try_output(fs::path(flags.answers.output) / "a file", flags.if_exists()));
  } else {
    SIGHTLINE_TRY(try_output(flags.answers.output, flags.if_exists()));
  }
  SIGHTLINE_TRY(flags.is_map() ? export_map(flags) : export_points(flags));
  print_exported(flags.answers.output);
  return {};
}

}  // namespace

Verb export_verb() {
  const auto flags = std::make_shared<ExportFlags>();
  Verb verb;
  verb.name = "export";
  verb.summary = "Write a map in formats of other programs";
  verb.details = concat(
      "From a map (.slmap): gpkg (QGIS, with a style) and geojson contain the route with the "
      "annotation of each site; csv is a folder of tables; cells is a table of the reader's "
      "answers in the cells of a grid; lanelet2 is the Lanelet2 map --lanes (Autoware's "
      "lanelet2_map.osm) with the answers along each lanelet; mcap contains NDs, route, and sites "
      "with "
      "their answers for Foxglove, with a drive along them at 10 m/s; ply contains the NDs as "
      "coloured "
      "Gaussians (viewers of Gaussian splats; CloudCompare shows points); pcd contains their "
      "means, with the number of points as "
      "intensity.\n\n"
      "From a configuration (.yaml): autoware is a map directory of 20 m squares; pcd and ply "
      "contain its points; octomap is the space that rays found free or occupied (.bt: octovis, "
      "octomap_server), without moving objects, in voxels of --leaf and up to "
      "remove-moving.carve_range_m from the sensor.\n\n"
      "Without --format the ending of the output decides: .gpkg, .geojson, .osm, .csv (cells), "
      ".pcd, .ply, .bt, .mcap; a folder is csv or autoware.",
      kLanelet2Details,
      "\n\nExports are in the coordinates of the recordings, so positions in an export and in the "
      "reader are equal. Point clouds whose coordinates exceed 100 km (UTM) are shifted by whole "
      "100 km, like squares of MGRS; the reader's export_origin_world_m is that shift.");
  verb.examples = {"sightline export town.slmap -o route.gpkg",
                   "sightline export town.slmap --world utm:32N -o route.geojson",
                   "sightline export town.slmap --lanes lanelet2_map.osm -o answered.osm",
                   "sightline export town.slmap --cell 5 -o cells.csv",
                   "sightline export town.slmap --format csv -o tables/",
                   "sightline export town.slmap -o town.mcap",
                   "sightline export town.slmap -o nds.ply",
                   "sightline export town.yaml --format autoware -o town_map/",
                   "sightline export town.yaml -o town.bt"};
  verb.flags = {
      required_output_flag(flags->answers.output,
                           "The file to write; for csv and autoware: the folder"),
      force_flag(flags->answers.is_forced),
      {.names = "--format",
       .value = "FORMAT",
       .help = "Format of the output; without it the ending of the output decides",
       .target = &flags->format,
       .choices = {"autoware", "cells", "csv", "geojson", "gpkg", "lanelet2", "mcap", "octomap",
                   "pcd", "ply"},
       .remedies = conversions()},
      world_flag(flags->answers.world),
      {.names = "--leaf",
       .value = "METRES",
       .help = "Edge of the voxels in which points are thinned to one centroid; 0 keeps all. For "
               "octomap: edge of its voxels",
       .target = &flags->leaf_m,
       .minimum = 0.0,
       .maximum = 100.0}};
  add_answers_flags(verb, flags->answers);
  add_run_flags(verb, flags->run);
  verb.positionals.front().name = "TARGET";
  verb.positionals.front().help = "A map (.slmap) or a configuration (.yaml)";
  verb.run = [flags] { return exit_status_of(run_export(*flags)); };
  return verb;
}

}  // namespace sightline
