#include "examples/town/write_town.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "examples/town/drive/drive.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/open_recording.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

namespace fs = std::filesystem;

class TownFiles : public TestInFolder {
 protected:
  WriteTownOptions options(const std::string& name) const {
    WriteTownOptions options;
    options.town = {4, 20.0};
    options.out = folder_ / name;
    options.drives = 1;
    options.spacing_m = 5.0;
    options.threads = 1;
    return options;
  }
};

std::map<std::string, std::vector<std::byte>> contents(const fs::path& folder) {
  std::map<std::string, std::vector<std::byte>> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = value_of(read_file(entry.path()));
  }
  return files;
}

std::vector<std::vector<double>> read_numbers(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    rows.emplace_back();
    for (double value = 0.0; fields >> value;) rows.back().push_back(value);
  }
  return rows;
}

TEST_F(TownFiles, AreTheSameBytesForAnyNumberOfThreads) {
  WriteTownOptions one = options("one");
  WriteTownOptions two = options("two");
  two.threads = 2;
  ASSERT_TRUE(write_town(one).has_value());
  ASSERT_TRUE(write_town(two).has_value());
  const auto files = contents(one.out);
  EXPECT_EQ(files.size(), 5U + 5U + 3U + 1U);  // scans of two drives, poses, town.json
  EXPECT_EQ(files, contents(two.out));
}

TEST_F(TownFiles, SayWhetherTrafficAndReturnsAreOtherThanUsual) {
  const auto town_json = [](const WriteTownOptions& options) {
    SIGHTLINE_CHECK(write_town(options).has_value());
    return value_of(read_text_file(options.out / "town.json"));
  };
  WriteTownOptions usual = options("usual");
  EXPECT_EQ(town_json(usual).find("traffic"), std::string::npos);
  WriteTownOptions hard = options("hard");
  hard.traffic = 5.0;
  hard.missing_share = 0.25;
  const std::string json = town_json(hard);
  EXPECT_NE(json.find("\"traffic\": 5.0"), std::string::npos);
  EXPECT_NE(json.find("\"missing_share\": 0.25"), std::string::npos);
  const auto size_of = [](const WriteTownOptions& options) {
    return fs::file_size(options.out / "drive_1" / "scans" / "000002.pcd");
  };
  EXPECT_LT(static_cast<double>(size_of(hard)), 0.8 * static_cast<double>(size_of(usual)));
}

TEST_F(TownFiles, AreABagWithTimesAndTurnRatesWhereTheDriveIsSwept) {
  WriteTownOptions swept = options("swept");
  swept.is_swept = true;
  swept.town.seed = 7;
  ASSERT_TRUE(write_town(swept).has_value());
  WriteTownOptions again = swept;
  again.out = folder_ / "again";
  again.threads = 2;
  ASSERT_TRUE(write_town(again).has_value());
  EXPECT_EQ(contents(swept.out), contents(again.out));

  RecordingOptions recorded;
  recorded.scans = (swept.out / "drive_1" / "drive.mcap").string();
  recorded.poses = recorded.scans;
  recorded.lidar_z_m = 1.8;
  const Recording recording = value_of(open_recording(recorded));
  EXPECT_TRUE(recording.warnings.empty()) << recording.warnings.front();
  ASSERT_EQ(recording.scans.size(), 5U);
  const Town town = *make_town(swept.town);
  DriveOptions drive_options = usual_drive(town.options, 1, *town_sensor(16));
  drive_options.spacing_m = swept.spacing_m;
  drive_options.is_swept = true;
  const DriveSimulator drive = value_of(DriveSimulator::make(town, drive_options));
  for (std::size_t i = 0; i < 5; ++i) {
    ASSERT_TRUE(recording.scans[i].T_world_vehicle.has_value());
    EXPECT_TRUE(recording.scans[i].T_world_vehicle->isApprox(drive.T_town_vehicle()[i], 1e-9));
  }
  const Scan scan = value_of(recorded_scan_store(recording)->read(2));
  const TownScan truth = drive.scan(2);
  ASSERT_EQ(scan.points_m.size(), truth.points.size());
  EXPECT_EQ(scan.time_offset_ns, truth.time_offset_ns);
  EXPECT_GT(scan.time_offset_ns.back(), 99'000'000);
  EXPECT_EQ(scan.points_m[777], truth.points[777].position_m.cast<double>());
  // 0.5 s before to 1 s behind: 0.9 s in steps of 5 ms and both ends.
  ASSERT_EQ(recording.turn_rates.size(), 301U);
  for (const TurnRate& rate : recording.turn_rates) {
    const double time_s = 1e-9 * static_cast<double>(rate.stamp_ns - recording.scans[0].stamp_ns);
    const Eigen::AngleAxisd turn(drive.T_town_vehicle_at(time_s - 0.0005).linear().transpose() *
                                 drive.T_town_vehicle_at(time_s + 0.0005).linear());
    const Eigen::Vector3d rate_radps = turn.axis() * turn.angle() / 0.001;
    EXPECT_LT((rate.rate_rad_per_s - rate_radps).norm(), 0.04) << "bias and noise";
  }
}

TEST_F(TownFiles, DifferWithTheSeed) {
  WriteTownOptions one = options("one");
  WriteTownOptions other = options("other");
  other.town.seed = 5;
  ASSERT_TRUE(write_town(one).has_value());
  ASSERT_TRUE(write_town(other).has_value());
  EXPECT_NE(contents(one.out).at("mapping/scans/000000.pcd"),
            contents(other.out).at("mapping/scans/000000.pcd"));
}

TEST_F(TownFiles, ReadBackAsPointCloudsWithoutLoss) {
  const WriteTownOptions written = options("one");
  ASSERT_TRUE(write_town(written).has_value());
  const PointCloudFile cloud =
      value_of(read_point_cloud(written.out / "drive_1" / "scans" / "000002.pcd"));
  EXPECT_GT(cloud.points_m.size(), 10000U);
  EXPECT_EQ(cloud.nonfinite_count, 0U);
  EXPECT_EQ(cloud.zero_count, 0U);
}

TEST_F(TownFiles, PosesKeepMillimetresFarFromTheOrigin) {
  WriteTownOptions near = options("near");
  WriteTownOptions far = options("far");
  near.drives = far.drives = 0;
  far.origin_world_m = Eigen::Vector2d(587500.5, 4139250.25);
  ASSERT_TRUE(write_town(near).has_value());
  ASSERT_TRUE(write_town(far).has_value());
  for (const char* name : {"poses.tum", "poses_true.tum"}) {
    const std::vector<std::vector<double>> a = read_numbers(near.out / "mapping" / name);
    const std::vector<std::vector<double>> b = read_numbers(far.out / "mapping" / name);
    ASSERT_EQ(a.size(), 5U);
    ASSERT_EQ(b.size(), 5U);
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(b[i].size(), 8U);
      EXPECT_NEAR(b[i][0], 0.1 * static_cast<double>(i), 1e-9);
      EXPECT_NEAR(b[i][1] - 587500.5, a[i][1], 2e-6);
      EXPECT_NEAR(b[i][2] - 4139250.25, a[i][2], 2e-6);
    }
  }
}

TEST_F(TownFiles, ReplaceAnEarlierTownOnlyWhenTold) {
  WriteTownOptions again = options("one");
  again.drives = 0;
  ASSERT_TRUE(write_town(options("one")).has_value());
  EXPECT_EQ(code_of(write_town(again)), ErrorCode::kOutputExists);
  again.replaces = true;
  ASSERT_TRUE(write_town(again).has_value());
  EXPECT_FALSE(fs::exists(again.out / "drive_1")) << "left over from the earlier town";
}

TEST_F(TownFiles, NeverReplaceWhatIsNoTown) {
  WriteTownOptions forced = options("thesis");
  forced.replaces = true;
  ASSERT_TRUE(write_file_atomically(forced.out / "chapter_1.txt", "Once", IfExists::kRefuse));
  EXPECT_EQ(code_of(write_town(forced)), ErrorCode::kOutputExists);
  EXPECT_TRUE(fs::exists(forced.out / "chapter_1.txt"));
}

TEST_F(TownFiles, RefuseBadArgumentsBeforeAnythingIsWritten) {
  for (const int fault : {0, 1, 2, 3}) {
    WriteTownOptions bad = options("bad");
    if (fault == 0) bad.town.length_m = 5.0;
    if (fault == 1) bad.drives = 10;
    if (fault == 2) bad.beams = 20;
    if (fault == 3) bad.spacing_m = -1.0;
    EXPECT_EQ(failure_of(write_town(bad), fault).code, ErrorCode::kBadArgument);
    EXPECT_FALSE(fs::exists(bad.out)) << fault;
  }
}

TEST_F(TownFiles, AreWhatANamedSensorSees) {
  WriteTownOptions ahead = options("ahead");
  ahead.drives = 0;
  ahead.sensor = "livox-avia";
  ASSERT_TRUE(write_town(ahead).has_value());
  const PointCloudFile scan = value_of(read_point_cloud(ahead.out / "mapping/scans/000001.pcd"));
  EXPECT_GT(scan.points_m.size(), 5000U);
  double widest = 0.0;
  for (const Eigen::Vector3d& point_m : scan.points_m) {
    widest = std::max(widest, std::abs(std::atan2(point_m.y(), point_m.x())));
  }
  EXPECT_NEAR(widest, 34.98 * std::numbers::pi / 180.0, 1e-3);
  const std::string facts = value_of(read_text_file(ahead.out / "town.json"));
  EXPECT_NE(facts.find("\"sensor\": \"livox-avia\""), std::string::npos);
  WriteTownOptions unknown = options("unknown");
  unknown.sensor = "livox-avio";
  EXPECT_EQ(write_town(unknown).error().code, ErrorCode::kUnknownName);
  EXPECT_FALSE(fs::exists(unknown.out));
}

}  // namespace
}  // namespace sightline::town
