#include "compiler/config/compile_config.h"

#include <algorithm>

#include "compiler/gate/settings.h"
#include "formats/annotation/measured_drives.h"
#include "passes/ingest/ingest.h"

// What a configuration may contain besides the options of passes.

namespace sightline {
namespace {

// Another sensor of the mapping drive: the keys of a drive but for those of its poses.
ConfigSection sensor_section(std::size_t index, RecordingOptions& options) {
  ConfigSection section{to_text(RecordingRole{RecordingUse::kOtherSensor, index}),
                        "Another sensor on the vehicle of the mapping drive, in the same frame and "
                        "on the same clock",
                        option_fields(options)};
  std::erase_if(section.fields, [](const OptionField& field) {
    return field.name.starts_with("pose") || field.name == "name";
  });
  return section;
}

// The key of a drive that is localized in a map.
OptionField align_field(RecordingOptions& options) {
  return flag("align", options.align,
              "subtract a constant offset of the given poses from the map's poses");
}

// A section of one drive, or of a list of them. What distinguishes drives of one vehicle is each
// one's own, the rest is as in the first unless it is said.
ConfigSection drives_section(const std::string& name, const std::string& help,
                             RecordingOptions& first, std::deque<RecordingOptions>& more,
                             std::string& recordings) {
  ConfigSection section{name, help, option_fields(first)};
  section.fields.push_back(
      text("recordings", recordings,
           "several drives instead of `scans` or a list: a folder of recordings (in natural order "
           "of their paths), or a text file with one path per line (and, after a tab, the path of "
           "its poses); poses and stamps are then names of files in or beside the folder of each "
           "recording; the other keys apply to all"));
  section.one_more = [&first, &more] {
    RecordingOptions& later = more.emplace_back(first);
    for (std::string* own : {&later.name, &later.scans, &later.poses, &later.stamps}) own->clear();
    return option_fields(later);
  };
  return section;
}

ConfigSection mapping_section(CompileConfig& config) {
  return drives_section("mapping",
                        "The drive that makes the map; or a list of drives of one vehicle, in "
                        "order of date, each with the keys that differ from the first",
                        config.mapping, config.later_mapping, config.mapping_recordings);
}

// Of a drive whose sensor may be that of another section.
void describe_inherited(std::vector<OptionField>& fields) {
  const auto sensor = std::ranges::find(fields, "sensor", &OptionField::name);
  sensor->help =
      "sensor, as under mapping; empty: sensor, beams, height and mounting of the mapping drive, "
      "or "
      "of the section map";
}

ConfigSection localization_section(CompileConfig& config) {
  ConfigSection section = drives_section(
      "localization",
      "A second drive that is matched against the map to measure localization "
      "errors; or a list of drives, each measured separately: the first must "
      "overlap the map, the others have the keys that differ from it",
      config.localization, config.later_localization, config.localization_recordings);
  describe_inherited(section.fields);
  section.fields.push_back(align_field(config.localization));
  section.one_more = [one_more = section.one_more, &later = config.later_localization] {
    std::vector<OptionField> fields = one_more();
    fields.push_back(align_field(later.back()));
    return fields;
  };
  return section;
}

ConfigSection evaluation_section(CompileConfig& config) {
  ConfigSection section{"evaluation",
                        "An independent drive that judges the finished map (sightline evaluate)",
                        option_fields(config.evaluation)};
  describe_inherited(section.fields);
  section.fields.push_back(align_field(config.evaluation));
  return section;
}

// A finished map: the keys of a drive that describe its sensor.
std::vector<OptionField> option_fields(MapOptions& options) {
  std::vector<OptionField> fields = {
      text("points", options.points,
           "a finished map instead of the mapping drive: .pcd, .ply or .las, a folder of them, "
           "Autoware's with pointcloud_map_metadata.yaml, Apollo's NDT map (config.xml and map/), "
           "or a compiled map (.slmap) to annotate again; empty: the mapping drive makes the map"),
      text("name", options.name, "name of the map; empty: the last part of the path `points`")};
  for (OptionField& field : option_fields(options.localizing)) {
    const bool is_of_sensor = field.name == "sensor" || field.name == "rings" ||
                              field.name == "height_m" || field.name.ends_with("_beam_deg") ||
                              field.name == "azimuth_view_deg" || field.name.starts_with("lidar_");
    if (!is_of_sensor) continue;
    if (field.name == "sensor") {
      field.help =
          "the LiDAR that will localize, as under mapping; empty: the one in the compiled map, "
          "else generic-16";
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

std::vector<OptionField> option_fields(RouteOptions& options) {
  return {
      text("file", options.file,
           "the route along which a finished map is annotated: Lanelet2 (.osm), .geojson, .csv "
           "of x, y and z, "
           "a trajectory (.tum), or `everywhere`: all ground that a vehicle can reach (section "
           "choose-field-sites)"),
      text("world", options.world,
           "coordinate system of the map, for lanes in latitude and longitude: local, utm:32N "
           "or enu:LATITUDE,LONGITUDE,ALTITUDE; local: annotation.world or the one in the compiled "
           "map")};
}

}  // namespace

std::vector<OptionField> option_fields(OutsideErrorsOptions& options) {
  return {
      text("file", options.file,
           "CSV with the header \"scan,look,start,error\" and one error per line: errors of your "
           "localizer on the localization drive, instead of measure-error; empty: none"),
      text("evaluation_file", options.evaluation_file,
           "CSV of its errors on the evaluation drive; empty: none"),
      text("localizer", options.localizer,
           "name of your localizer; it is stored in the map, and the vehicle passes it to the "
           "reader"),
      integer("version", options.version,
              "version of your localizer; raise it when its results change", 0, 1'000'000'000),
      text("parameters", options.parameters, "its parameters, for the record: \"name=value, ...\""),
      choice("reference", options.reference,
             "reference of the errors: the known pose, or the match at full range",
             {"known", "full-range"})};
}

std::vector<OptionField> option_fields(AnnotationOptions& options) {
  return {
      numbers("ranges_m", options.ranges_m, "observation ranges to choose from, m", 1.0, 300.0),
      looks("looks", options.looks,
            "looks to choose from, in order of matching time: each is a range and the sample of a "
            "scan that is matched; paper: observation ranges only, all returns within them"),
      numbers("limits_m", options.limits_m, "localization errors that a vehicle accepts, m", 0.01,
              5.0),
      number("leaf_m", options.leaf_m, "voxel size for subsampling a scan before matching, m", 0.05,
             10.0),
      number("tile_m", options.tile_m, "edge length of a map tile, m; a multiple of the cell", 8.0,
             1024.0),
      integer("seed", options.seed, "seed of all random numbers", 0, 1'000'000'000),
      text("world", options.world,
           "coordinate system of the recordings' poses, stored in the map: local, utm:ZONE "
           "(utm:32N), mgrs:SQUARE (mgrs:32UMV) or enu:LATITUDE,LONGITUDE,ALTITUDE"),
      choice("split", options.split,
             "even-odd: even scans of the mapping drive make the map, odd scans are localized in "
             "it; auto: even-odd where no localization drive is given",
             {"auto", "even-odd"}),
      choice(
          "model", options.model,
          "error model where --model names none; generated: the one that comes with the program, "
          "trained on generated worlds, if it is of these ranges, looks, limits and localizer; "
          "own: trained on the localization drives of this compile",
          {"own", "generated"})};
}

std::string to_text(const RecordingRole& role) {
  if (role.use == RecordingUse::kOtherSensor) return concat("mapping-", role.number + 2);
  if (role.use == RecordingUse::kLocalization) return localization_role(role.number);
  if (role.use == RecordingUse::kEvaluation) return "evaluation";
  return role.number == 0 ? "mapping" : concat("mapping[", role.number + 1, "]");
}

std::vector<ConfigSection> drive_sections(CompileConfig& config) {
  std::vector<ConfigSection> all = {
      {"annotation", "Ranges, limits and other settings that all passes share",
       option_fields(config.annotation)},
      mapping_section(config),
      {.name = "base",
       .help = "Poses of an earlier map, to add drives to it; or only the file",
       .fields = {text(
           "poses", config.base_poses,
           "poses file that was written beside an earlier map (.slposes): its drives, listed first "
           "under mapping, keep these poses, and later drives add scans only where they show "
           "something new (choose-scans); empty: all poses are estimated again")},
       .word = "poses"},
      {.name = "map",
       .help = "A finished map, annotated along `route`, instead of `mapping`; or only its file",
       .fields = option_fields(config.map),
       .word = "points"},
      {.name = "route",
       .help = "Where a finished map is annotated; or only the file, or `everywhere`",
       .fields = option_fields(config.route),
       .word = "file"}};
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    all.push_back(sensor_section(i, config.other_sensors[i]));
  }
  all.push_back(localization_section(config));
  all.push_back(evaluation_section(config));
  all.push_back({"import-errors", "Errors of your own localizer, measured by another program",
                 option_fields(config.outside)});
  return all;
}

ConfigSection gate_section() {
  return {"gate", "Requirements that a map must meet (sightline gate)", {}, gate_settings_schema()};
}

}  // namespace sightline
