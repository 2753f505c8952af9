#include "compiler/init/draft_config.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include "compiler/init/look_at_drive.h"
#include "formats/base/printable.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/grid/point_grid.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The text of a configuration with comments, and paths as they are seen from its folder.
class YamlText {
 public:
  // `folder`: absolute, of the file.
  explicit YamlText(fs::path folder) : folder_(std::move(folder)) {}

  // Broken into lines of at most 100 characters.
  void comment(const std::string& words, const std::string& indent = "") {
    constexpr std::size_t kWidth = 100;
    const std::string text = one_line(words);  // a name of a file could go on as keys
    std::string line = indent + "#";
    std::size_t begin = 0;
    while (begin < text.size()) {
      const std::size_t end = std::min(text.find(' ', begin), text.size());
      if (line.size() + 1 + end - begin > kWidth && line.size() > indent.size() + 1) {
        text_ += line + "\n";
        line = indent + "#";
      }
      line += " " + text.substr(begin, end - begin);
      begin = end + 1;
    }
    text_ += line + "\n";
  }
  // One that is written for every drive is read once.
  void comment_once(const std::string& text, const std::string& indent) {
    if (said_.insert(text).second) comment(text, indent);
  }
  void line(const std::string& text) { text_ += one_line(text) + "\n"; }

  // Beneath the file's folder relative, elsewhere absolute: then file and recordings may each move.
  [[nodiscard]] std::string path(const fs::path& absolute) const {
    const fs::path relative = absolute.lexically_relative(folder_);
    const bool is_beneath = !relative.empty() && *relative.begin() != "..";
    return is_beneath ? relative.string() : absolute.string();
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  fs::path folder_;
  std::string text_;
  std::set<std::string> said_;
};

// Fewer measure nothing; more than these name a drive.
constexpr std::size_t kFewestScans = 20;

struct Drives {
  std::vector<FoundDrive> drives;        // in the order of their roles
  std::vector<FoundDrive> same_vehicle;  // further sensors of the first drive
  std::vector<PassedOver> passed_over;
};

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_called_map(const FoundDrive& drive, const fs::path& folder) {
  for (const fs::path& part : drive.scans.lexically_relative(folder)) {
    if (lower(part.string()).starts_with("map")) return true;
  }
  return false;
}

// Whether one drive comes near the other for half of its way or more; without poses it may.
bool may_meet(const FoundDrive& a, const FoundDrive& b) {
  constexpr double kNear_m = 15.0;
  constexpr std::size_t kLooks = 50;
  if (a.positions_m.empty() || b.positions_m.empty()) return true;
  const PointGrid other(b.positions_m);
  std::size_t near = 0;
  for (std::size_t k = 0; k < kLooks; ++k) {
    if (other.nearest(a.positions_m[k * a.positions_m.size() / kLooks], kNear_m)) ++near;
  }
  return 2 * near >= kLooks;
}

void pass_over(const FoundDrive& drive, const std::string& reason, Drives& drives) {
  drives.passed_over.push_back({drive.scans, reason});
}

// The mapping drive first, then those that can be measured in its map.
Drives assign_roles(std::vector<FoundDrive> found, const fs::path& folder) {
  Drives drives;
  std::stable_partition(found.begin(), found.end(),
                        [&](const FoundDrive& drive) { return is_called_map(drive, folder); });
  // A few scans make no map where there is a drive beside them.
  std::stable_partition(found.begin(), found.end(),
                        [](const FoundDrive& drive) { return drive.scan_count >= kFewestScans; });
  for (FoundDrive& drive : found) {
    if (drives.drives.empty()) {
      drives.drives.push_back(std::move(drive));
      continue;
    }
    const FoundDrive& mapping = drives.drives.front();
    if (!drive.poses.empty() && drive.poses == mapping.poses && drive.scans != mapping.scans &&
        drive.scan_count >= kFewestScans) {
      drives.same_vehicle.push_back(std::move(drive));
    } else if (drive.scan_count < kFewestScans) {
      pass_over(drive, "fewer than 20 scans, too few for a drive", drives);
    } else if (!may_meet(drive, mapping)) {
      pass_over(
          drive,
          "by its poses it does not overlap the mapping drive; write another configuration for it",
          drives);
    } else if (drives.drives.size() == 3) {
      pass_over(drive,
                "three drives are already used; to use all recordings of a folder, replace `scans` "
                "by `recordings: FOLDER`, under mapping to make one map of them, under "
                "localization to measure each",
                drives);
    } else {
      drives.drives.push_back(std::move(drive));
    }
  }
  return drives;
}

// Without a slash at its end.
fs::path absolute_folder(const fs::path& folder) {
  const fs::path absolute = (fs::current_path() / folder).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

Result<Drives> look_at_all(const fs::path& folder, const std::string& sensor) {
  SIGHTLINE_ASSIGN(ScanSearch search, find_scans(folder));
  std::vector<FoundDrive> found;
  std::vector<PassedOver> passed_over = search.passed_over;
  for (const FoundScans& scans : search.found) {
    Result<FoundDrive> drive = look_at_drive(scans, sensor);
    if (drive) {
      found.push_back(std::move(*drive));
    } else {
      passed_over.push_back({scans.scans, drive.error().message});
    }
  }
  Drives drives = assign_roles(std::move(found), absolute_folder(folder));
  drives.passed_over.insert(drives.passed_over.begin(), passed_over.begin(), passed_over.end());
  return drives;
}

Error nothing_found(const fs::path& folder, const std::vector<PassedOver>& passed_over) {
  constexpr std::size_t kMost = 5;
  std::string message = concat(
      "found no drive; expected a folder of ", scan_endings_text(),
      " files, a ROS bag (.bag, .db3, .mcap) or a pcap of a Velodyne, Hesai or Ouster sensor");
  for (std::size_t i = 0; i < std::min(kMost, passed_over.size()); ++i) {
    message += concat("; ", passed_over[i].path.string(), ": ", passed_over[i].reason);
  }
  if (passed_over.size() > kMost) message += concat("; and ", passed_over.size() - kMost, " more");
  return {ErrorCode::kEmptyDirectory, message, folder.string()};
}

bool is_path(const GuessedKey& guess) {
  return guess.key == "poses" || guess.key == "stamps" ||
         (guess.key == "sensor" && is_sensor_file(guess.value));
}

std::string length_text(const FoundDrive& drive) {
  if (drive.positions_m.empty()) return "";
  return concat(", ", static_cast<int>(std::lround(drive.length_m)), " m by its poses");
}

void write_other_sensors(const Drives& drives, YamlText& yaml) {
  std::vector<std::string> others;
  for (const FoundDrive& drive : drives.same_vehicle) {
    others.push_back("scans: " + yaml_scalar(yaml.path(drive.scans)));
  }
  const FoundDrive& first = drives.drives.front();
  for (const std::string& topic : first.other_topics) {
    others.push_back(
        concat("scans: ", yaml_scalar(yaml.path(first.scans)), ", topic: ", yaml_scalar(topic)));
  }
  if (others.empty()) return;
  yaml.line("");
  yaml.comment(
      "The same vehicle has more sensors. Their mounting is unknown: measure it, enter it and "
      "remove the # (mapping-2 to mapping-4).");
  for (std::size_t i = 0; i < others.size(); ++i) {
    yaml.line(concat("# mapping-", i + 2, ": {", others[i],
                     ", lidar_x_m: 0, lidar_y_m: 0, lidar_z_m: 0, lidar_yaw_deg: 0}"));
  }
}

void write_drive(const FoundDrive& drive, const std::string& role, YamlText& yaml) {
  yaml.line(role + ":");
  yaml.comment(concat(drive.contents, length_text(drive), "."), "  ");
  yaml.line("  scans: " + yaml_scalar(yaml.path(drive.scans)));
  for (const GuessedKey& guess : drive.keys) {
    if (!guess.reason.empty()) yaml.comment_once(concat(guess.key, ": ", guess.reason, "."), "  ");
    yaml.line(concat("  ", guess.key, ": ",
                     yaml_scalar(is_path(guess) ? yaml.path(guess.value) : guess.value)));
  }
}

void write_head(const fs::path& folder, const fs::path& file, const std::string& schema,
                YamlText& yaml) {
  if (!schema.empty()) yaml.line("# yaml-language-server: $schema=" + schema);
  const std::string name = file.empty() ? "drive.yaml" : file.filename().string();
  yaml.comment(concat("Written by `sightline init` from the files in ", folder.string(),
                      ". A comment gives the reason for each guessed value; check them."));
  yaml.line("#");
  yaml.line(concat("#   sightline compile ", name, " -o ", fs::path(name).stem().string(),
                   ".slmap     # makes the map"));
  yaml.line("#   sightline passes --config     # every other key with its default");
  yaml.line("#");
  yaml.comment("Paths are relative to the folder of this file.");
  yaml.line("");
}

// How to judge the map; `mapping`: as this drive.
void write_evaluation(const FoundDrive& mapping, const std::string& task, YamlText& yaml) {
  yaml.line("");
  yaml.comment(concat(task,
                      " To use one, remove the # below and name it. Without `sensor`, it has "
                      "that of the mapping drive."));
  yaml.line("# evaluation:");
  yaml.line("#   scans: another-drive/");
  if (!mapping.poses.empty()) yaml.line("#   poses: another-drive/poses.txt");
}

// What this drive cannot do alone.
void write_shortness(const FoundDrive& mapping, YamlText& yaml) {
  constexpr double kTwoBlocks_m = 30.0;
  const bool is_too_short = mapping.positions_m.empty() ? mapping.scan_count < kFewestScans
                                                        : mapping.length_m < kTwoBlocks_m;
  yaml.line("");
  if (is_too_short) {
    yaml.comment(
        "This drive is too short to train an error model on (two blocks of 15 m): compile with "
        "--model FILE, a model that `sightline train` has trained on other drives.");
  } else {
    yaml.comment(
        "A map made from this drive alone has no promise for the next drive. A promise needs a "
        "model "
        "of other drives with 1.2 km of route: `sightline train` makes it.");
  }
}

std::string summary_of(const FoundDrive& drive, const std::string& role) {
  std::string sensor;
  for (const GuessedKey& guess : drive.keys) {
    if (guess.key == "sensor") sensor = fs::path(guess.value).filename().string();
    if (guess.key == "rings") sensor = guess.value + " rings";
  }
  return concat(role, ": ", drive.scans.string(), ", ", drive.scan_count, " scans, ", sensor, ", ",
                (drive.poses.empty() ? "poses to be estimated"
                                     : "poses " + fs::path(drive.poses).filename().string()));
}

}  // namespace

Result<ConfigDraft> draft_config(const fs::path& folder, const fs::path& file,
                                 const DraftOptions& options) {
  constexpr std::array<const char*, 3> kRoles = {"mapping", "localization", "evaluation"};
  constexpr std::array<const char*, 3> kTasks = {
      "The drive that makes the map.",
      "A second drive that is matched against the map, to measure localization errors.",
      "An independent drive that judges the finished map (sightline evaluate)."};
  const bool is_beams_file = is_sensor_file(options.sensor);
  if (!options.sensor.empty() && !is_beams_file) SIGHTLINE_TRY(sensor_profile(options.sensor));
  const std::string sensor =
      is_beams_file ? absolute_folder(options.sensor).string() : options.sensor;
  SIGHTLINE_ASSIGN(const Drives drives, look_at_all(folder, sensor));
  if (drives.drives.empty()) return nothing_found(folder, drives.passed_over);
  ConfigDraft draft;
  YamlText yaml(absolute_folder(file.parent_path()));
  write_head(folder, file, options.schema, yaml);
  for (std::size_t i = 0; i < drives.drives.size(); ++i) {
    if (i > 0) yaml.line("");
    yaml.comment(kTasks[i]);
    write_drive(drives.drives[i], kRoles[i], yaml);
    if (i == 0) write_other_sensors(drives, yaml);
    draft.summary.push_back(summary_of(drives.drives[i], kRoles[i]));
  }
  if (drives.drives.size() == 1) {
    yaml.line("");
    yaml.comment("With one drive, even scans make the map and odd scans are localized in it.");
    yaml.line("annotation:");
    yaml.line("  split: even-odd");
  }
  if (drives.drives.size() < kRoles.size()) {
    write_evaluation(drives.drives.front(), kTasks.back(), yaml);
  }
  write_shortness(drives.drives.front(), yaml);
  if (!drives.passed_over.empty()) yaml.line("");
  for (const PassedOver& passed : drives.passed_over) {
    yaml.comment(concat("Not used: ", yaml.path(passed.path), ": ", passed.reason, "."));
  }
  draft.yaml = yaml.text();
  return draft;
}

}  // namespace sightline
