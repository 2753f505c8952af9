#include "examples/town/write_town.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <system_error>

#include "examples/town/bag/write_bag.h"
#include "examples/town/drive/constraint.h"
#include "examples/town/drive/drive.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "formats/foreign/clouds/pcd_writer.h"

namespace sightline::town {
namespace {

namespace fs = std::filesystem;

constexpr int kMostDrives = 9;
constexpr int kTownVersion = 1;  // raised when the same seed gives another town

std::string drive_name(int drive) {
  return drive == 0 ? "mapping" : "drive_" + std::to_string(drive);
}

std::string tum_line(std::int64_t stamp_ns, const Pose& T_town_vehicle,
                     const Eigen::Vector2d& origin_world_m) {
  const Eigen::Vector3d t = T_town_vehicle.translation();
  const Eigen::Quaterniond q(T_town_vehicle.linear());
  std::array<char, 256> line{};
  const int size =
      std::snprintf(line.data(), line.size(), "%.6f %.6f %.6f %.6f %.12f %.12f %.12f %.12f\n",
                    1e-9 * static_cast<double>(stamp_ns), t.x() + origin_world_m.x(),
                    t.y() + origin_world_m.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  return std::string(line.data(), static_cast<std::size_t>(size));
}

Result<void> write_poses(const fs::path& path, const DriveSimulator& drive,
                         const std::vector<Pose>& poses, const Eigen::Vector2d& origin_world_m) {
  std::string text;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    text += tum_line(drive.stamp_ns(i), poses[i], origin_world_m);
  }
  return write_file_atomically(path, text, IfExists::kRefuse);
}

Result<void> write_scan(const fs::path& folder, const DriveSimulator& drive, std::size_t index) {
  std::vector<PointXyzi> points;
  for (const LabelledPoint& p : drive.scan(index).points) {
    points.push_back({p.position_m.x(), p.position_m.y(), p.position_m.z(), p.intensity});
  }
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "%06zu.pcd", index);
  return write_pcd_binary(folder / name.data(), points);
}

Result<void> write_scans(const fs::path& folder, const DriveSimulator& drive, int threads) {
  // Every scan has its own slot for a failure; the first of them is reported.
  std::vector<std::optional<Error>> failures(drive.scan_count());
  parallel_for(drive.scan_count(), threads, [&](std::size_t i) {
    const Result<void> written = write_scan(folder, drive, i);
    if (!written) failures[i] = written.error();
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

Result<void> write_places(const fs::path& path, const Town& town) {
  std::string text = "from_m,to_m,kind\n";
  std::array<char, 96> line{};
  for (const Place& place : town.places) {
    const std::string kind(place_kind_name(place.kind));
    std::snprintf(line.data(), line.size(), "%.3f,%.3f,%s\n", place.from_m, place.to_m,
                  kind.c_str());
    text += line.data();
  }
  return write_file_atomically(path, text, IfExists::kRefuse);
}

Result<void> write_scan_places(const fs::path& path, const Town& town,
                               const DriveSimulator& drive) {
  std::string text = "scan,driven_m,kind\n";
  std::array<char, 96> line{};
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const std::string kind(place_kind_name(place_at(town.places, drive.driven_m(i)).kind));
    std::snprintf(line.data(), line.size(), "%zu,%.6f,%s\n", i, drive.driven_m(i), kind.c_str());
    text += line.data();
  }
  return write_file_atomically(path, text, IfExists::kRefuse);
}

Result<void> write_constraints(const fs::path& path, const Town& town, const DriveSimulator& drive,
                               const WriteTownOptions& options) {
  std::vector<std::size_t> scans;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const double since_m = scans.empty()
                               ? options.constraints_m
                               : std::abs(drive.driven_m(i) - drive.driven_m(scans.back()));
    if (since_m >= options.constraints_m) scans.push_back(i);
  }
  const std::vector<Constraint> found = parallel_map<Constraint>(
      scans.size(), options.threads, [&](std::size_t i) { return constraint_of(drive, scans[i]); });
  std::string text = "scan,driven_m,kind,kept_ahead,kept_left,sigma_ahead_m,sigma_left_m\n";
  std::array<char, 160> line{};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const double s_m = drive.driven_m(scans[i]);
    const std::string kind(place_kind_name(place_at(town.places, s_m).kind));
    std::snprintf(line.data(), line.size(), "%zu,%.3f,%s,%.3f,%.3f,%.4f,%.4f\n", scans[i], s_m,
                  kind.c_str(), found[i].kept_ahead, found[i].kept_left, found[i].sigma_ahead_m,
                  found[i].sigma_left_m);
    text += line.data();
  }
  return write_file_atomically(path, text, IfExists::kRefuse);
}

Result<SensorProfile> sensor_of(const WriteTownOptions& options) {
  return options.sensor.empty() ? town_sensor(options.beams) : town_sensor(options.sensor);
}

Result<DriveOptions> drive_options_of(const WriteTownOptions& options, const Town& town,
                                      int number) {
  SIGHTLINE_ASSIGN(const SensorProfile sensor, sensor_of(options));
  DriveOptions drive = usual_drive(town.options, static_cast<std::uint64_t>(number), sensor);
  drive.spacing_m = options.spacing_m;
  for (const PartialDrive& part : options.parts) {
    if (part.drive != number) continue;
    drive.from_m = part.from_m;
    drive.length_m = part.to_m - part.from_m;
  }
  const auto is_among = [&](const std::vector<int>& drives) {
    return std::ranges::find(drives, number) != drives.end();
  };
  drive.is_in_next_lane = is_among(options.in_next_lane);
  drive.is_back = is_among(options.back);
  drive.traffic = options.traffic;
  drive.missing_share = options.missing_share;
  drive.is_swept = options.is_swept;
  drive.has_fog = options.has_fog;
  drive.covered_deg = options.covered_deg;
  return options.is_by_hand ? carried_by_hand(drive) : drive;
}

// Beside the scans of a hard world.
Result<void> write_hard_truth(const fs::path& folder, const WriteTownOptions& options,
                              const Town& town, const DriveSimulator& drive) {
  SIGHTLINE_TRY(write_scan_places(folder / "scans.csv", town, drive));
  if (options.constraints_m == 0.0) return {};
  return write_constraints(folder / "constraints.csv", town, drive, options);
}

Result<void> write_drive(const WriteTownOptions& options, const Town& town, int number) {
  SIGHTLINE_ASSIGN(const DriveOptions drive_options, drive_options_of(options, town, number));
  SIGHTLINE_ASSIGN(const DriveSimulator drive, DriveSimulator::make(town, drive_options));
  const fs::path folder = options.out / drive_name(number);
  const bool maps = number == 0;
  const std::vector<Pose>& truth = drive.T_town_vehicle();
  if (options.is_swept) {
    const std::vector<Pose> poses = maps ? drive.disturbed_poses() : truth;
    const std::uint64_t seed = mix(town.options.seed, static_cast<std::uint64_t>(number));
    SIGHTLINE_TRY(write_bag(folder / "drive.mcap", drive, poses,
                            {seed, options.origin_world_m, options.threads, town.is_hard()}));
  } else {
    SIGHTLINE_TRY(write_scans(folder / "scans", drive, options.threads));
  }
  if (town.is_hard()) SIGHTLINE_TRY(write_hard_truth(folder, options, town, drive));
  if (maps) {
    SIGHTLINE_TRY(write_poses(folder / "poses_true.tum", drive, truth, options.origin_world_m));
  }
  return write_poses(folder / "poses.tum", drive, maps ? drive.disturbed_poses() : truth,
                     options.origin_world_m);
}

void describe_world(nlohmann::ordered_json& json, const WriteTownOptions& options,
                    const Town& town) {
  if (town.is_hard()) {
    json["world"] = world_kind_name(options.town.world);
    if (options.town.is_bare) json["is_bare"] = true;
  }
  if (options.has_fog) json["has_fog"] = true;
  if (options.covered_deg != 0.0) json["covered_deg"] = options.covered_deg;
}

std::string describe(const WriteTownOptions& options, const Town& town) {
  nlohmann::ordered_json json;
  json["town_version"] = kTownVersion;
  json["seed"] = options.town.seed;
  json["length_m"] = options.town.length_m;
  json["is_round"] = options.town.is_round;
  json["spacing_m"] = options.spacing_m;
  if (options.is_by_hand) json["is_by_hand"] = true;
  if (options.is_swept) json["is_swept"] = true;
  if (options.traffic != 1.0) json["traffic"] = options.traffic;
  if (options.missing_share != 0.0) json["missing_share"] = options.missing_share;
  describe_world(json, options, town);
  json["sensor"] =
      options.sensor.empty() ? "generic-" + std::to_string(options.beams) : options.sensor;
  json["origin_world_m"] = {options.origin_world_m.x(), options.origin_world_m.y()};
  json["localization_drives"] = options.drives;
  for (const PartialDrive& part : options.parts) {
    json["parts"].push_back(
        {{"drive", drive_name(part.drive)}, {"from_m", part.from_m}, {"to_m", part.to_m}});
  }
  if (!options.in_next_lane.empty()) json["in_next_lane"] = options.in_next_lane;
  if (!options.back.empty()) json["back"] = options.back;
  if (const TownChange& change = options.town.change; change.is_any()) {
    json["change"] = {{"from_m", change.from_m},         {"to_m", change.to_m},
                      {"rebuilds", change.rebuilds},     {"removes_wall", change.removes_wall},
                      {"added_cars", change.added_cars}, {"noise_factor", change.noise_factor}};
  }
  for (const Board& board : options.town.boards) {
    json["boards"].push_back({{"x_m", board.pose.position_m.x() + options.origin_world_m.x()},
                              {"y_m", board.pose.position_m.y() + options.origin_world_m.y()},
                              {"facing_deg", board.pose.yaw_rad * 180.0 / std::numbers::pi},
                              {"width_m", board.width_m},
                              {"height_m", board.height_m}});
  }
  json["streets"] = nlohmann::ordered_json::array();
  for (const Street& street : town.plan.streets) {
    if (!street.is_on_route() || street.route_from_m >= options.town.length_m) continue;
    json["streets"].push_back({{"kind", street_kind_name(street.kind)},
                               {"from_m", street.route_from_m},
                               {"to_m", std::min(street.route_to_m, options.town.length_m)},
                               {"width_m", street.left_m + street.right_m}});
  }
  return json.dump(2) + "\n";
}

// Refuses a folder with anything in it, or removes the town that lies there: of another length it
// would leave scans behind.
Result<void> make_room(const WriteTownOptions& options) {
  std::error_code code;
  if (!fs::exists(options.out, code) || fs::is_empty(options.out, code)) return {};
  const bool is_town = fs::exists(options.out / "mapping", code);
  if (!options.replaces || !is_town) {
    return Error{ErrorCode::kOutputExists,
                 is_town ? "the folder already contains a town; --force replaces it"
                         : "expected a new or empty folder, or an earlier town",
                 options.out.string(),
                 {}};
  }
  fs::remove(options.out / "town.json", code);
  fs::remove(options.out / "places.csv", code);
  for (int number = 0; number <= kMostDrives && !code; ++number) {
    fs::remove_all(options.out / drive_name(number), code);
  }
  if (code) return Error{ErrorCode::kCannotWrite, code.message(), options.out.string(), {}};
  return {};
}

}  // namespace

Result<void> write_town(const WriteTownOptions& options) {
  if (options.drives < 0 || options.drives > kMostDrives) {
    return Error{ErrorCode::kBadArgument,
                 std::to_string(options.drives) + " drives; expected 0 to 9",
                 {},
                 {}};
  }
  SIGHTLINE_TRY(sensor_of(options));
  SIGHTLINE_ASSIGN(const Town town, make_town(options.town));
  SIGHTLINE_TRY(make_room(options));
  for (int number = 0; number <= options.drives; ++number) {
    SIGHTLINE_TRY(write_drive(options, town, number));
  }
  if (town.is_hard()) SIGHTLINE_TRY(write_places(options.out / "places.csv", town));
  return write_file_atomically(options.out / "town.json", describe(options, town),
                               IfExists::kRefuse);
}

}  // namespace sightline::town
