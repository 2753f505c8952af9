#include "compiler/config/same_recordings.h"

#include <algorithm>
#include <map>

#include "formats/foreign/recording/same_recording.h"

namespace sightline {
namespace {

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

Result<void> check_named_once(const std::vector<NamedDrive>& drives,
                              const std::filesystem::path& file) {
  std::map<std::string, std::string> role_of;
  for (const NamedDrive& drive : drives) {
    const auto [other, is_new] = role_of.try_emplace(drive.place.name(), drive.role);
    if (is_new) continue;
    return Error{ErrorCode::kBadValue,
                 drive.role + ".scans: found the recording of " + other->second +
                     ", expected another drive: a recording that is listed twice counts twice",
                 file.string()};
  }
  return {};
}

// The first drive that is the same recording; nullptr: there is none.
const NamedDrive* same_drive(const std::vector<NamedDrive>& drives, const RecordingPlace& place) {
  const auto found = std::ranges::find_if(
      drives, [&](const NamedDrive& drive) { return is_same_recording(drive.place, place); });
  return found == drives.end() ? nullptr : &*found;
}

void become_split(CompileConfig& config) {
  config.localization = {};
  config.later_localization.clear();
  config.localization_recordings.clear();
  config.localization.world = config.annotation.world;
}

}  // namespace

Result<void> settle_same_recordings(const std::filesystem::path& file, CompileConfig& config) {
  const std::vector<NamedDrive> mapping = drives_for(RecordingUse::kMapping, config);
  const std::vector<NamedDrive> localization = drives_for(RecordingUse::kLocalization, config);
  SIGHTLINE_TRY(check_named_once(mapping, file));
  SIGHTLINE_TRY(check_named_once(localization, file));
  // The mapping drive that each is; files are compared once.
  std::vector<const NamedDrive*> own;
  for (const NamedDrive& drive : localization) own.push_back(same_drive(mapping, drive.place));
  const auto first = std::ranges::find_if(own, [](const NamedDrive* drive) { return drive; });
  const bool is_other = first == own.end();
  if (is_other && config.annotation.split == Split::kEvenOdd && !localization.empty()) {
    return Error{ErrorCode::kBadValue,
                 "annotation.split is even-odd and a localization drive is named: choose one",
                 file.string()};
  }
  if (is_other) return {};
  const std::string found = localization[static_cast<std::size_t>(first - own.begin())].role +
                            ".scans: found the recording of " + (*first)->role;
  if (std::ranges::find(own, nullptr) != own.end()) {
    return Error{ErrorCode::kBadValue,
                 found + ", expected a drive that did not make the map, as the others: remove it",
                 file.string()};
  }
  if (config.imports_errors()) {
    return Error{ErrorCode::kBadValue,
                 found +
                     ", expected another drive: of a drive that makes the map every second scan is "
                     "localized, and import-errors has errors of all",
                 file.string()};
  }
  become_split(config);
  config.notes.push_back(found +
                         ": every second scan of the mapping drives makes the map, the others are "
                         "localized in it; what is set under localization is not used");
  return {};
}

void note_known_evaluation(CompileConfig& config) {
  const RecordingPlace place = place_of(config.evaluation);
  const std::vector<NamedDrive> mapping = drives_for(RecordingUse::kMapping, config);
  const std::vector<NamedDrive> localization = drives_for(RecordingUse::kLocalization, config);
  const bool is_split_drive =
      config.is_split() && !mapping.empty() && is_same_recording(mapping.front().place, place);
  if (is_split_drive) return;
  const NamedDrive* known = same_drive(mapping, place);
  if (known == nullptr) known = same_drive(localization, place);
  if (known == nullptr) return;
  config.notes.push_back("evaluation.scans: found the recording of " + known->role +
                         ", which the map is made from: the results are better than those of "
                         "another drive");
}

}  // namespace sightline
