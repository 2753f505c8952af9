#include "compiler/config/input_files.h"
#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/maps/foreign_maps.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/sensor_file.h"

#include <algorithm>

namespace sightline {
namespace {

namespace fs = std::filesystem;

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

}  // namespace sightline
