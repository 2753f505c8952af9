#include "compiler/config/compile_config.h"

#include "compiler/gate/settings.h"
#include "formats/annotation/measured_drives.h"
#include "passes/ingest/ingest.h"

// What a configuration may say besides the options of passes.

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

// A section of one drive, or of a list of them. What distinguishes drives of one vehicle is each
// one's own, the rest is as in the first unless it is said.
ConfigSection drives_section(const std::string& name, const std::string& help,
                             RecordingOptions& first, std::deque<RecordingOptions>& more,
                             std::string& recordings) {
  ConfigSection section{name, help, option_fields(first)};
  section.fields.push_back(text(
      "recordings", recordings,
      "several drives in place of `scans` or a list: a folder of recordings, taken in natural "
      "order of their paths, or a file with a path a line (behind a tab, its poses); poses and "
      "stamps are then names of files that lie with the scans of each or beside them, the other "
      "keys hold for all"));
  section.one_more = [&first, &more] {
    RecordingOptions& later = more.emplace_back(first);
    for (std::string* own : {&later.name, &later.scans, &later.poses, &later.stamps}) own->clear();
    return option_fields(later);
  };
  return section;
}

ConfigSection mapping_section(CompileConfig& config) {
  return drives_section("mapping",
                        "The drive that makes the map; or a list of drives of one vehicle, in the "
                        "order of their days, each with what differs from the first",
                        config.mapping, config.later_mapping, config.mapping_recordings);
}

ConfigSection localization_section(CompileConfig& config) {
  return drives_section("localization",
                        "A second drive that is matched against the map to measure error; or a "
                        "list of drives, each measured by itself: the first has to come near the "
                        "map, the others say what differs from it",
                        config.localization, config.later_localization,
                        config.localization_recordings);
}

// A finished map: the keys of a drive that tell of its sensor.
std::vector<OptionField> option_fields(MapOptions& options) {
  std::vector<OptionField> fields = {
      text("points", options.points,
           "a finished map in place of the mapping drive: .pcd, .ply or .las, a folder of them, "
           "Autoware's with pointcloud_map_metadata.yaml, Apollo's NDT map (config.xml and map/), "
           "or a compiled map (.slmap) to annotate anew; empty: the drive makes the map"),
      text("name", options.name, "name of the map; empty: the last part of points")};
  for (OptionField& field : option_fields(options.localizing)) {
    const bool tells_of_sensor = field.name == "sensor" || field.name == "rings" ||
                                 field.name == "height_m" || field.name.ends_with("_beam_deg") ||
                                 field.name == "azimuth_view_deg" ||
                                 field.name.starts_with("lidar_");
    if (!tells_of_sensor) continue;
    if (field.name == "sensor") {
      field.help =
          "the LiDAR that will localize, as under mapping; empty: that of a compiled map, "
          "else generic-16";
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

std::vector<OptionField> option_fields(RouteOptions& options) {
  return {text("file", options.file,
               "where a finished map is annotated: Lanelet2 (.osm), .geojson, .csv of x, y and z, "
               "a trajectory (.tum), or everywhere that a vehicle reaches (everywhere; section "
               "choose-field-sites)"),
          text("world", options.world,
               "how the map lies on Earth, for lanes in latitude and longitude: local, utm:32N or "
               "enu:LATITUDE,LONGITUDE,ALTITUDE; local: as a compiled map says")};
}

}  // namespace

std::vector<OptionField> option_fields(OutsideErrorsOptions& options) {
  return {
      text("file", options.file,
           "CSV with a line \"scan,look,start,error\" and one error a line: what a localizer of "
           "yours made of the localization drive, in place of measure-error; empty: none"),
      text("evaluation_file", options.evaluation_file, "the same of the evaluation drive"),
      text("localizer", options.localizer,
           "its name, which the map keeps and the vehicle gives to the reader"),
      integer("version", options.version, "raise it when that localizer changes", 0, 1'000'000'000),
      text("parameters", options.parameters,
           "what the name leaves open, for the record: \"name=value, ...\""),
      choice("reference", options.reference,
             "what the errors were measured against: the known pose, or the match at full range",
             {"known", "full-range"})};
}

std::vector<OptionField> option_fields(AnnotationOptions& options) {
  return {numbers("ranges_m", options.ranges_m, "observation ranges to choose from, m", 1.0, 300.0),
          looks("looks", options.looks,
                "looks to choose from, each a range and the sample of a scan that is matched, from "
                "the cheapest to the dearest; paper: observation ranges alone, every return within "
                "them"),
          numbers("limits_m", options.limits_m, "localization errors a vehicle may accept, m", 0.01,
                  5.0),
          number("leaf_m", options.leaf_m, "voxel grid a scan is subsampled on to be matched, m",
                 0.05, 10.0),
          number("tile_m", options.tile_m, "edge of a map tile, m; a multiple of the cell", 8.0,
                 1024.0),
          integer("seed", options.seed, "seed of everything random", 0, 1'000'000'000),
          text("world", options.world,
               "where the recordings' coordinates lie, which the map carries: local, utm:ZONE "
               "(utm:32N), mgrs:SQUARE (mgrs:32UMV) or enu:LATITUDE,LONGITUDE,ALTITUDE"),
          choice("split", options.split,
                 "even-odd: even scans of the mapping drive map, odd ones localize; auto: so where "
                 "no localization drive is named",
                 {"auto", "even-odd"})};
}

std::string to_text(const RecordingRole& role) {
  if (role.use == RecordingUse::kOtherSensor) return concat("mapping-", role.number + 2);
  if (role.use == RecordingUse::kLocalization) return localization_role(role.number);
  if (role.use == RecordingUse::kEvaluation) return "evaluation";
  return role.number == 0 ? "mapping" : concat("mapping[", role.number + 1, "]");
}

std::vector<ConfigSection> drive_sections(CompileConfig& config) {
  std::vector<ConfigSection> all = {
      {"annotation", "What is annotated, and what all passes share",
       option_fields(config.annotation)},
      mapping_section(config),
      {.name = "base",
       .help = "What was shipped, for a map with more drives; or the file alone",
       .fields = {text("poses", config.base_poses,
                       "poses that were written beside an earlier map (.slposes): its drives, "
                       "named first under mapping, keep them, and others lay what is new "
                       "(choose-scans); empty: poses are found anew")},
       .word = "poses"},
      {.name = "map",
       .help = "A finished map, annotated along `route`, in place of `mapping`; or its file alone",
       .fields = option_fields(config.map),
       .word = "points"},
      {.name = "route",
       .help = "Where a finished map is annotated; or the file alone, or `everywhere`",
       .fields = option_fields(config.route),
       .word = "file"}};
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    all.push_back(sensor_section(i, config.other_sensors[i]));
  }
  all.push_back(localization_section(config));
  all.push_back({"evaluation",
                 "An independent drive that judges the finished map (sightline evaluate)",
                 option_fields(config.evaluation)});
  all.push_back({"import-errors", "Errors that a localizer of yours made, measured outside",
                 option_fields(config.outside)});
  return all;
}

ConfigSection gate_section() {
  return {"gate", "What a map must hold to pass (sightline gate)", {}, gate_settings_schema()};
}

}  // namespace sightline
