#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/watched_work.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/file_kind.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/judge/map_files.h"
#include "compiler/driver/configuration.h"
#include "compiler/views/replay/replay_files.h"
#include "compiler/views/replay/replay_report.h"
#include "formats/base/portable_math.h"
#include "formats/base/units.h"
#include "formats/foreign/recording/listed_scan_store.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

struct LocalizeFlags {
  std::string input;
  std::vector<std::string> overrides;
  std::string drive;              // section of the configuration; empty: see drive_of()
  std::vector<std::string> maps;  // files, or folders of these
  std::string output;
  bool is_forced = false;
  std::vector<std::string> start;  // X Y Z YAW
  bool starts_from_nothing = false;
  double limit_m = 0.0;
  double every_return_m = 0.0;
  std::string compared;
  bool is_aligned = false;
  double most_apart_s = 0.01;
  double delta = 1.0;
  std::string delta_unit = "f";
  std::string format = "text";
  int threads = 0;
  int json_progress = 0;
};

bool is_configuration(const LocalizeFlags& flags) {
  const std::optional<FileKind> kind = kind_of_file(flags.input);
  return kind != FileKind::kFolder && kind != FileKind::kRecording;
}

// A configuration of that one recording where no file is one.
Result<CompileConfig> config_of(const LocalizeFlags& flags) {
  if (is_configuration(flags)) return load_compile_config(flags.input, flags.overrides);
  std::vector<std::string> overrides = {"mapping.scans=" + flags.input};
  overrides.insert(overrides.end(), flags.overrides.begin(), flags.overrides.end());
  return compile_config_of(overrides);
}

// The drive that is named; else the first that did not make the map.
Result<RecordingOptions> drive_of(const CompileConfig& config, const LocalizeFlags& flags) {
  const std::pair<std::string, const RecordingOptions*> drives[] = {
      {"evaluation", &config.evaluation},
      {"localization", &config.localization},
      {"mapping", &config.mapping}};
  for (const auto& [section, drive] : drives) {
    if (!flags.drive.empty() && flags.drive != section) continue;
    if (!drive->scans.empty()) return *drive;
  }
  return Error{ErrorCode::kMissingKey,
               concat(flags.drive.empty() ? "no recording is named" : flags.drive + ".scans",
                      ": expected the recording to localize"),
               flags.input};
}

// Where neither is local, both are in one world; a recording in degrees is read in the map's.
Result<void> settle_world(const std::string& map_world, RecordingOptions& drive) {
  if (drive.world == kLocalWorld) drive.world = map_world;
  if (map_world == kLocalWorld || drive.world == map_world) return {};
  return Error{ErrorCode::kMismatchedInputs,
               concat("the recording is in the world ", drive.world, ", the map in ", map_world),
               drive.scans};
}

Result<std::optional<Pose>> start_of(const LocalizeFlags& flags) {
  if (flags.start.empty()) return std::optional<Pose>();
  std::array<double, 4> numbers{};
  if (flags.start.size() != numbers.size()) {
    return Error{ErrorCode::kBadArgument, "--start is given twice, expected it once", "", ""};
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string& word = flags.start[i];
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), numbers[i]);
    if (failure == std::errc() && end == word.data() + word.size() && std::isfinite(numbers[i])) {
      continue;
    }
    return Error{ErrorCode::kBadValue,
                 concat("--start: found '", word, "', expected metres X Y Z and degrees YAW"), "",
                 ""};
  }
  Pose start = Pose::Identity();
  const SinCos yaw = portable_sin_cos(numbers[3] * kRadPerDeg);
  start.linear() << yaw.cos, -yaw.sin, 0.0, yaw.sin, yaw.cos, 0.0, 0.0, 0.0, 1.0;
  start.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  return std::optional(start);
}

// What is replayed, and in what.
struct Opened {
  Recording recording;
  std::vector<ListedScan> scans;
  JoinedMaps maps;
};

std::vector<ListedScan> listed(const Recording& recording) {
  std::vector<ListedScan> scans;
  for (const RecordedScan& scan : recording.scans) {
    scans.push_back({scan.stamp_ns, scan.name, scan.T_world_vehicle});
  }
  return scans;
}

// In the order of the file; rows without times belong to the scans in their order.
Result<std::vector<TimedPose>> reference_poses(const LocalizeFlags& flags,
                                               const std::vector<ListedScan>& scans) {
  SIGHTLINE_ASSIGN(const std::vector<PoseRow> rows, read_poses(flags.compared, PoseFormat::kAuto));
  std::vector<TimedPose> poses;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].stamp_ns && i >= scans.size()) break;
    poses.push_back(
        {rows[i].stamp_ns ? *rows[i].stamp_ns : scans[i].stamp_ns, rows[i].T_world_vehicle});
  }
  return poses;
}

Result<ComparedPoses> compare(const LocalizeFlags& flags, const std::vector<TimedPose>& reference,
                              const std::vector<ListedScan>& scans, const ReplayedDrive& drive) {
  ComparedPoses compared;
  compared.file = flags.compared;
  compared.options = {std::llround(flags.most_apart_s * 1e9), flags.is_aligned, flags.delta,
                      flags.delta_unit == "m" ? DeltaUnit::kMetres : DeltaUnit::kFrames};
  std::vector<TimedPose> poses;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (drive.scans[i].state != ScanState::kLocalized) continue;
    poses.push_back({scans[i].stamp_ns, drive.scans[i].T_world_vehicle});
  }
  Result<TrajectoryErrors> errors = trajectory_errors(reference, poses, compared.options);
  if (!errors) return in_file(errors.error(), flags.compared);
  compared.errors = *errors;
  return compared;
}

// The sensor is that of the configuration. A recording alone is taken to be of the maps' sensor.
Result<JoinedMaps> open_maps(const LocalizeFlags& flags, const std::vector<std::string>& files,
                             const SensorProfile& sensor) {
  JoinedMapsOptions options;
  options.threads = flags.threads;
  if (is_configuration(flags) || sensor.name != SensorProfile().name) {
    options.azimuth_step_deg = sensor.azimuth_step_deg;
    options.T_vehicle_sensor = sensor.T_vehicle_lidar;
  }
  return JoinedMaps::open(files, options);
}

Result<Opened> open(const LocalizeFlags& flags) {
  SIGHTLINE_ASSIGN(const CompileConfig config, config_of(flags));
  SIGHTLINE_ASSIGN(RecordingOptions options, drive_of(config, flags));
  SIGHTLINE_ASSIGN(const std::vector<std::string> files, map_files(flags.maps));
  SIGHTLINE_ASSIGN(const std::string world, world_of(files));
  SIGHTLINE_TRY(settle_world(world, options));
  SIGHTLINE_ASSIGN(Recording recording, list_recording(options));
  std::vector<ListedScan> scans = listed(recording);
  SIGHTLINE_ASSIGN(JoinedMaps maps, open_maps(flags, files, recording.sensor));
  recording.sensor.T_vehicle_lidar = maps.T_vehicle_sensor();
  return Opened{std::move(recording), std::move(scans), std::move(maps)};
}

Result<ReplayOptions> replay_options(const LocalizeFlags& flags) {
  ReplayOptions options;
  SIGHTLINE_ASSIGN(options.T_world_start, start_of(flags));
  options.starts_from_nothing = flags.starts_from_nothing;
  options.limit_m = flags.limit_m;
  if (flags.every_return_m > 0.0) options.every_return_m = flags.every_return_m;
  return options;
}

std::vector<std::string> warnings_of(const LocalizeFlags& flags, const Opened& opened) {
  std::vector<std::string> warnings = opened.recording.warnings;
  for (std::size_t i = 0; i < opened.maps.count() && flags.every_return_m <= 0.0; ++i) {
    if (opened.maps.fault(i)) continue;
    const MapInfo& map = opened.maps.reader(i).info();
    if (map.is_for_caller) continue;
    warnings.push_back(concat("the map ", opened.maps.count() > 1 ? opened.maps.file(i) + " " : "",
                              "is for the localizer ", map.localizer,
                              ": it names no look for this one, which matches every return within ",
                              format_double(map.ranges_m.back()), " m"));
  }
  return warnings;
}

Result<void> put_report(const LocalizeFlags& flags, const ReplayReport& report) {
  if (flags.format == "json") {
    print_data(to_json(report));
  } else if (verbosity() != Verbosity::kQuiet || flags.output.empty()) {
    print_text(to_text(report));
  }
  return {};
}

Result<void> localize(const LocalizeFlags& flags) {
  SIGHTLINE_TRY(try_output(flags.output, if_exists(flags.is_forced)));
  SIGHTLINE_TRY(start_of(flags));  // before anything is read
  SIGHTLINE_ASSIGN(Opened opened, open(flags));
  SIGHTLINE_ASSIGN(const ReplayOptions options, replay_options(flags));
  std::vector<TimedPose> reference;
  if (!flags.compared.empty()) {
    SIGHTLINE_ASSIGN(reference, reference_poses(flags, opened.scans));
  }
  const std::shared_ptr<const ScanStore> store = listed_scan_store(opened.recording);
  const ReplayInputs inputs{opened.maps, opened.recording.sensor, *store, opened.scans};
  ReplayedDrive drive;
  SIGHTLINE_TRY(
      do_watched({"localize", flags.threads, flags.json_progress, warnings_of(flags, opened)},
                 [&](PassContext& ctx) -> Result<void> {
                   SIGHTLINE_ASSIGN(drive, replay_drive(ctx, options, inputs));
                   return {};
                 }));
  ReplayReport report{
      opened.recording.name, maps_of(opened.maps, drive), figures_of(opened.scans, drive), {}};
  if (!flags.compared.empty()) {
    SIGHTLINE_ASSIGN(report.compared, compare(flags, reference, opened.scans, drive));
  }
  if (!flags.output.empty()) {
    SIGHTLINE_TRY(write_poses(flags.output, opened.scans, drive, if_exists(flags.is_forced)));
    if (flags.format == "text") print_written(flags.output);
  }
  return put_report(flags, report);
}

std::vector<Flag> flags_of_comparison(LocalizeFlags& flags) {
  return {{.names = "--compare",
           .value = "FILE",
           .help = "Print absolute and relative errors beside these poses (TUM, KITTI, Apollo), "
                   "computed as evo_ape and evo_rpe do",
           .target = &flags.compared},
          {.names = "--align",
           .help = "With --compare: align the poses first by one rotation and translation",
           .target = &flags.is_aligned},
          {.names = "--most-apart",
           .value = "SECONDS",
           .help = "With --compare: largest difference in time of two poses that are compared",
           .target = &flags.most_apart_s,
           .minimum = 0.0,
           .maximum = 1000.0},
          {.names = "--relative-over",
           .value = "NUMBER",
           .help = "With --compare: relative errors are over so many of --relative-unit",
           .target = &flags.delta,
           .minimum = 0.001,
           .maximum = 1e6},
          {.names = "--relative-unit",
           .value = "UNIT",
           .help = "Unit of --relative-over: f (frames) or m (metres along the poses)",
           .target = &flags.delta_unit,
           .choices = {"f", "m"}}};
}

std::vector<Flag> flags_of_replay(LocalizeFlags& flags) {
  return {
      {.names = "--map",
       .value = "FILE",
       .help = "The map to localize in (.slmap), or a folder of maps; several maps of one world "
               "(annotation.world) are used as one",
       .target = &flags.maps,
       .is_required = true},
      {.names = "-o,--output",
       .value = "FILE",
       .help = "Write the poses: TUM (.tum, .txt), CSV (.csv) or MCAP (.mcap)",
       .target = &flags.output,
       .endings = {".tum", ".txt", ".csv", ".mcap"}},
      force_flag(flags.is_forced),
      {.names = "--drive",
       .value = "SECTION",
       .help = "Recording of the configuration to localize; default: the first of evaluation, "
               "localization and mapping that is named",
       .target = &flags.drive,
       .choices = {"mapping", "localization", "evaluation"}},
      {.names = "--set",
       .value = "KEY=VALUE",
       .help = "Override one value of the configuration: section.key=value; paths are relative "
               "to the current folder, not to the configuration",
       .target = &flags.overrides},
      {.names = "--start",
       .value = "X Y Z YAW",
       .help = "Pose of the vehicle at the first scan, right to about 3 m and 5 degrees: metres "
               "in the world of the map, degrees from its x axis; default: the first pose of "
               "the recording, or a search of the whole map where it has none",
       .target = &flags.start},
      {.names = "--from-nothing",
       .help = "Use no pose of the recording: search the whole map for the first scan, and for a "
               "vehicle that is lost",
       .target = &flags.starts_from_nothing},
      {.names = "--limit",
       .value = "METRES",
       .help = "One of the map's limits; 0: the tightest",
       .target = &flags.limit_m,
       .minimum = 0.0},
      {.names = "--every-return",
       .value = "METRES",
       .help = "Match every return within this distance instead of what the map names: slow, "
               "for comparison; 0: by the map",
       .target = &flags.every_return_m,
       .minimum = 0.0,
       .maximum = 1000.0}};
}

}  // namespace

Verb localize_verb() {
  const auto flags = std::make_shared<LocalizeFlags>();
  Verb verb;
  verb.name = "localize";
  verb.summary = "Localize a recording in a map, scan after scan, as a vehicle does";
  verb.details =
      "Each scan starts where the two poses before it predict, and is matched by the map's plan. "
      "The first one starts from --start or from the recording's own pose (poses or GNSS of the "
      "configuration), and up to 3 m around it; where there is none, the whole map is searched, "
      "and a scan that fits two places begins nothing. Prints four lines: how many scans were "
      "localized; "
      "how often the vehicle was lost; the processor time of a scan beside the time between scans; "
      "and where the poses are in doubt, by numbers of scans and positions in the world.\n\n"
      "In doubt are poses of the plan's second look, which are expected where a first look is not "
      "enough and cost time, and scans that contradict the map. After three scans in a row that "
      "contradict it the vehicle is lost, and is searched for from the recording's poses, or "
      "from its last pose and in the whole map. Poses of lost scans are not written. A drive of "
      "another place is refused.\n\n"
      "Of several maps the one with the nearest place is used, until the vehicle is beyond its "
      "reach; at most two are in memory. A map that cannot be read is named in a warning, and the "
      "others are used.";
  verb.examples = {
      "sightline localize town.yaml --map town.slmap -o poses.tum",
      "sightline localize drive.mcap --map town.slmap --start 12.5 -3.0 0.2 90 -o poses.mcap",
      "sightline localize town.yaml --map town.slmap --compare truth.txt --align",
      "sightline localize town.yaml --map north.slmap --map south.slmap",
      "sightline localize town.yaml --map town.slmap --format json"};
  verb.positionals = {
      {.name = "RECORDING",
       .help = "A configuration (.yaml), a bag, a capture or a folder of scans; without a "
               "configuration, its sensor is taken to be the map's",
       .target = &flags->input}};
  verb.flags = flags_of_replay(*flags);
  const std::vector<Flag> compared = flags_of_comparison(*flags);
  verb.flags.insert(verb.flags.end(), compared.begin(), compared.end());
  verb.flags.push_back({.names = "--format",
                        .value = "FORMAT",
                        .help = "Form of the summary; json as schemas/localize.schema.json "
                                "describes it",
                        .target = &flags->format,
                        .choices = {"text", "json"}});
  verb.flags.push_back(threads_flag(flags->threads));
  verb.flags.push_back(json_progress_flag(flags->json_progress));
  verb.run = [flags] { return exit_status_of(localize(*flags)); };
  return verb;
}

}  // namespace sightline
