#include "compiler/config/inputs.h"

#include <algorithm>
#include <map>
#include <optional>

#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/maps/foreign_maps.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/recording/same_recording.h"
#include "formats/foreign/text/sensor_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Error bad_value(const std::string& message) { return {ErrorCode::kBadValue, message}; }

Result<void> add_recording(const RecordingOptions& options, InputFiles& inputs) {
  if (options.scans.empty()) return {};
  SIGHTLINE_ASSIGN(const Recording recording, list_recording(options));
  for (const RecordedScan& scan : recording.scans) inputs.files.push_back(recording.file_of(scan));
  for (const std::string& file : {options.poses, options.stamps, options.calibration}) {
    if (!file.empty()) inputs.files.emplace_back(file);
  }
  if (is_sensor_file(options.sensor)) inputs.files.emplace_back(options.sensor);
  if (!recording.container) inputs.folders.emplace_back(options.scans);
  return {};
}

void sort_once(std::vector<fs::path>& paths) {
  std::ranges::sort(paths);
  paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
}

std::string escaped(const std::string& path) {
  std::string text;
  for (const char c : path) {
    if (c == ' ' || c == '#') text += '\\';
    if (c == '$') text += '$';
    text += c;
  }
  return text;
}

struct NamedDrive {
  std::string role;
  RecordingPlace place;
};

std::vector<NamedDrive> drives_for(RecordingUse use, const CompileConfig& config) {
  std::vector<NamedDrive> drives;
  visit_recordings(config, [&](const RecordingRole& role, const RecordingOptions& recording) {
    if (role.use != use || recording.scans.empty()) return;
    drives.push_back({to_text(role), place_of(recording)});
  });
  return drives;
}

Result<void> check_named_once(const std::vector<NamedDrive>& drives) {
  std::map<std::string, std::string> role_of;
  for (const NamedDrive& drive : drives) {
    const auto [other, is_new] = role_of.try_emplace(drive.place.name(), drive.role);
    if (is_new) continue;
    return bad_value(concat(drive.role, ".scans: found the recording of ", other->second,
                            ", expected another drive: the same recording is listed twice"));
  }
  return {};
}

// The first drive that is the same recording; nullptr: there is none.
const NamedDrive* same_drive(const std::vector<NamedDrive>& drives, const RecordingPlace& place) {
  const auto found = std::ranges::find_if(
      drives, [&](const NamedDrive& drive) { return is_same_recording(drive.place, place); });
  return found == drives.end() ? nullptr : &*found;
}

// The role of the mapping or localization drive that is also the evaluation drive.
std::optional<std::string> role_of_evaluation(const CompileConfig& config,
                                              const std::vector<NamedDrive>& mapping) {
  const RecordingPlace place = place_of(config.evaluation);
  const std::vector<NamedDrive> localization = drives_for(RecordingUse::kLocalization, config);
  for (const std::vector<NamedDrive>* drives : {&mapping, &localization}) {
    if (const NamedDrive* known = same_drive(*drives, place)) return known->role;
  }
  return std::nullopt;
}

void become_split(CompileConfig& config) {
  config.localization = CompileConfig().localization;
  config.later_localization.clear();
  config.localization_recordings.clear();
  config.localization.world = config.annotation.world;
}

}  // namespace

Result<InputFiles> input_files(const CompileConfig& config, const fs::path& file,
                               const fs::path& model) {
  InputFiles inputs;
  if (!file.empty()) inputs.files.push_back(file);
  if (!model.empty()) inputs.files.push_back(model);
  std::vector<const RecordingOptions*> recordings;
  visit_recordings(config, [&](const RecordingRole& role, const RecordingOptions& recording) {
    if (role.use != RecordingUse::kEvaluation) recordings.push_back(&recording);
  });
  for (const RecordingOptions* recording : recordings) {
    SIGHTLINE_TRY(add_recording(*recording, inputs));
  }
  for (const std::string& named : {config.mapping_recordings, config.localization_recordings}) {
    if (named.empty()) continue;
    std::error_code ignored;
    (fs::is_directory(named, ignored) ? inputs.folders : inputs.files).emplace_back(named);
  }
  if (config.has_map()) {
    const std::string& map = config.map.points;
    SIGHTLINE_ASSIGN(const std::vector<fs::path> pieces,
                     config.map.is_apollo ? list_apollo_map(map) : list_point_map(map));
    inputs.files.insert(inputs.files.end(), pieces.begin(), pieces.end());
    if (!config.route.is_everywhere()) inputs.files.emplace_back(config.route.file);
    if (pieces.size() > 1) inputs.folders.push_back(pieces.front().parent_path());
  }
  if (!config.base_poses.empty()) inputs.files.emplace_back(config.base_poses);
  if (config.imports_errors()) inputs.files.emplace_back(config.outside.file);
  sort_once(inputs.files);
  sort_once(inputs.folders);
  return inputs;
}

std::string depfile_text(const std::string& target, const InputFiles& inputs) {
  std::string text = escaped(target) + ":";
  for (const std::vector<fs::path>* paths : {&inputs.files, &inputs.folders}) {
    for (const fs::path& path : *paths) text += " \\\n  " + escaped(path.string());
  }
  return text + "\n";
}

Result<void> settle_same_recordings(CompileConfig& config) {
  const std::vector<NamedDrive> mapping = drives_for(RecordingUse::kMapping, config);
  const std::vector<NamedDrive> localization = drives_for(RecordingUse::kLocalization, config);
  SIGHTLINE_TRY(check_named_once(mapping));
  SIGHTLINE_TRY(check_named_once(localization));
  // The mapping drive that each is; files are compared once.
  std::vector<const NamedDrive*> own;
  for (const NamedDrive& drive : localization) own.push_back(same_drive(mapping, drive.place));
  const auto first = std::ranges::find_if(own, [](const NamedDrive* drive) { return drive; });
  const bool is_other = first == own.end();
  if (is_other && config.annotation.split == Split::kEvenOdd && !localization.empty()) {
    return bad_value(
        "annotation.split is even-odd, but a localization drive is given; remove one of them");
  }
  if (is_other) return {};
  const std::string found = concat(localization[static_cast<std::size_t>(first - own.begin())].role,
                                   ".scans: found the recording of ", (*first)->role);
  if (std::ranges::find(own, nullptr) != own.end()) {
    return bad_value(found +
                     ", expected a drive that did not make the map; remove it from the list");
  }
  if (config.imports_errors()) {
    return bad_value(found +
                     ", expected another drive: import-errors has errors of all its scans, but "
                     "only every second scan of a mapping drive is localized");
  }
  become_split(config);
  config.notes.push_back(found +
                         ": every second scan of the mapping drives makes the map, the others are "
                         "localized in it; the other keys of localization are ignored");
  return {};
}

bool is_known_evaluation(const CompileConfig& config) {
  return role_of_evaluation(config, drives_for(RecordingUse::kMapping, config)).has_value();
}

}  // namespace sightline
