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
  SIGHTLINE_ASSIGN(const town::Town made, town::make_town(options.town));
  SIGHTLINE_ASSIGN(SensorProfile sensor, town::town_sensor(16));
  sensor.T_vehicle_lidar.translation().x() = -1.5;
  town::DriveOptions drive_options = town::usual_drive(made.options, 0, sensor);
  drive_options.spacing_m = 0.5 * options.spacing_m;
  SIGHTLINE_ASSIGN(const town::DriveSimulator drive,
                   town::DriveSimulator::make(made, drive_options));
  const std::filesystem::path folder = options.out / "mapping" / "rear";
  std::string stamps;
  for (std::size_t i = 1; i < drive.scan_count(); i += 2) {
    std::vector<PointXyzi> points;
    for (const town::LabelledPoint& point : drive.scan(i).points) {
      const Eigen::Vector3f& at_m = point.position_m;
      points.push_back({at_m.x(), at_m.y(), at_m.z(), point.intensity});
    }
    const std::string number = std::to_string(i);
    const std::filesystem::path file = folder / (std::string(4 - number.size(), '0') + number);
    SIGHTLINE_TRY(write_pcd_binary(file.string() + ".pcd", points, IfExists::kReplace));
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
    SIGHTLINE_TRY(town::write_town(options));
    if (golden.has_second_sensor) SIGHTLINE_TRY(write_second_sensor(options));
    SIGHTLINE_ASSIGN(const std::string config, read_text_file(configs / (golden.name + ".yaml")));
    SIGHTLINE_TRY(
        write_file_atomically(folder / golden.name / "town.yaml", config, IfExists::kReplace));
  }
  return {};
}

}  // namespace sightline::golden
