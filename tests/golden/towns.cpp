#include "tests/golden/towns.h"

#include "examples/town/drive/drive.h"
#include "examples/town/write_town.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/clouds/pcd_writer.h"

namespace sightline::golden {
namespace {

struct GoldenTown {
  std::string name;
  int beams = 16;
  int drives = 0;                  // beside the one that maps
  bool has_second_sensor = false;  // on the vehicle that maps
};

const std::vector<GoldenTown> kTowns = {{"town16", 16, 1, false}, {"town64", 64, 0, true}};

town::WriteTownOptions options_of(const GoldenTown& golden, const std::filesystem::path& folder) {
  town::WriteTownOptions options;
  options.town.seed = 3;
  options.town.length_m = 60.0;
  options.out = folder / golden.name;
  options.drives = golden.drives;
  options.beams = golden.beams;
  options.replaces = true;
  return options;
}

// What a sensor of 16 beams at the back of the mapping vehicle sees, halfway between the scans of
// the first: every other scan of a drive with twice as many.
Result<void> write_second_sensor(const town::WriteTownOptions& options) {
  const Result<town::Town> town = town::make_town(options.town);
  if (!town) return town.error();
  Result<SensorProfile> sensor = town::town_sensor(16);
  if (!sensor) return sensor.error();
  sensor->T_vehicle_lidar.translation().x() = -1.5;
  town::DriveOptions drive_options = town::usual_drive(town->options, 0, *sensor);
  drive_options.spacing_m = 0.5 * options.spacing_m;
  const Result<town::DriveSimulator> drive = town::DriveSimulator::make(*town, drive_options);
  if (!drive) return drive.error();
  const std::filesystem::path folder = options.out / "mapping" / "rear";
  std::string stamps;
  for (std::size_t i = 1; i < drive->scan_count(); i += 2) {
    std::vector<PointXyzi> points;
    for (const town::LabelledPoint& point : drive->scan(i).points) {
      const Eigen::Vector3f& at_m = point.position_m;
      points.push_back({at_m.x(), at_m.y(), at_m.z(), point.intensity});
    }
    const std::string number = std::to_string(i);
    const std::filesystem::path file = folder / (std::string(4 - number.size(), '0') + number);
    const Result<void> written =
        write_pcd_binary(file.string() + ".pcd", points, IfExists::kReplace);
    if (!written) return written;
    stamps +=
        std::to_string(0.05 * static_cast<double>(i)) + "\n";  // one drive takes twice as long
  }
  return write_file_atomically(options.out / "mapping" / "rear_stamps.txt", stamps,
                               IfExists::kReplace);
}

}  // namespace

std::vector<std::string> town_names() {
  std::vector<std::string> names;
  for (const GoldenTown& town : kTowns) names.push_back(town.name);
  return names;
}

Result<void> write_towns(const std::filesystem::path& configs,
                         const std::filesystem::path& folder) {
  for (const GoldenTown& golden : kTowns) {
    const town::WriteTownOptions options = options_of(golden, folder);
    Result<void> written = town::write_town(options);
    if (written && golden.has_second_sensor) written = write_second_sensor(options);
    if (!written) return written;
    const Result<std::string> config = read_text_file(configs / (golden.name + ".yaml"));
    if (!config) return config.error();
    const Result<void> copied =
        write_file_atomically(folder / golden.name / "town.yaml", *config, IfExists::kReplace);
    if (!copied) return copied;
  }
  return {};
}

}  // namespace sightline::golden
