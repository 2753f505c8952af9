#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"
#include "tests/system/program.h"

// `sightline localize` in two maps of one town.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;

constexpr int kScans = 141;

std::string scan_name(int number) {
  std::ostringstream name;
  name << std::setw(6) << std::setfill('0') << number << ".pcd";
  return name.str();
}

// The scans from `first` on of a drive of the town, with their poses.
void link_part(const fs::path& drive, const fs::path& part, int first, int count) {
  fs::create_directories(part / "scans");
  std::istringstream poses(bytes_of(drive / "poses.tum"));
  std::ofstream rest(part / "poses.tum");
  std::string line;
  for (int i = 0; i < first + count && std::getline(poses, line); ++i) {
    if (i < first) continue;
    rest << line << '\n';
    fs::create_symlink(drive / "scans" / scan_name(i), part / "scans" / scan_name(i));
  }
}

void compile_part(const fs::path& town, const std::string& name, int first, int count) {
  for (const char* drive : {"mapping", "drive_1"}) {
    link_part(town / drive, town / name / drive, first, count);
  }
  fs::copy(town / "town.yaml", town / name / "town.yaml");
  run_successfully("compile " + (town / name / "town.yaml").string() +
                   " -q --set annotation.world=utm:32N -o " +
                   (town / "maps" / (name + ".slmap")).string());
}

// A street of 140 m: maps of its first and last 84 m.
const fs::path& town_of_two_maps() {
  static const fs::path kTown = [] {
    const fs::path town = scratch_folder() / "two_maps";
    make_town(town, "--seed 3 --length-m 140 --drives 1 --origin-m 456500,5429500");
    fs::create_directories(town / "maps");
    compile_part(town, "west", 0, 85);
    compile_part(town, "east", 56, 85);
    return town;
  }();
  return kTown;
}

std::string map_of(const std::string& name) {
  return (town_of_two_maps() / "maps" / (name + ".slmap")).string();
}
std::string localize_with(const std::string& flags) {
  return "localize " + (town_of_two_maps() / "town.yaml").string() + " " + flags + " ";
}
std::string both() { return "--map " + map_of("west") + " --map " + map_of("east"); }

TEST(JoinedMaps, FollowADriveFromOneIntoTheOther) {
  const ProgramResult run = run_successfully(localize_with(both()) + "--format json --compare " +
                                             (town_of_two_maps() / "drive_1/poses.tum").string());
  const Json json = Json::parse(run.out);
  const Json schema =
      Json::parse(bytes_of(fs::path(SIGHTLINE_ROOT) / "schemas/localize.schema.json"));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json["scans"], kScans);
  EXPECT_EQ(json["localized"], kScans);
  EXPECT_LT(json["compared"]["absolute_m"]["max"], 0.15);
  ASSERT_EQ(json["maps"].size(), 2U);
  EXPECT_EQ(json["maps"][0]["file"], map_of("west"));
  EXPECT_GT(json["maps"][0]["localized"], 80);
  EXPECT_GT(json["maps"][1]["localized"], 40);
  EXPECT_TRUE(json["maps"][1]["fault"].is_null());
  EXPECT_THAT(run_successfully(localize_with(both())).out,
              AllOf(HasSubstr("\nMaps       "), HasSubstr("west.slmap "), HasSubstr("; ")));
}

TEST(JoinedMaps, GiveThePosesOfEachMapWhileItIsThePresentOne) {
  const fs::path folder = fresh_folder();
  const auto poses = [&](const std::string& name, const std::string& maps) {
    run_successfully(localize_with(maps) + "-q -o " + (folder / name).string());
    return bytes_of(folder / name);
  };
  const std::string alone = poses("alone.tum", "--map " + map_of("west"));
  const std::string joined = poses("joined.tum", both());
  std::size_t end = 0;
  for (int line = 0; line < 90; ++line) end = joined.find('\n', end) + 1;
  EXPECT_EQ(joined.substr(0, end), alone.substr(0, end));
  EXPECT_NE(joined, alone);
  const fs::path maps = town_of_two_maps() / "maps";
  EXPECT_EQ(poses("folder.tum", "--map " + maps.string()), joined);
}

TEST(JoinedMaps, AreAllSearchedWhereNoStartIsKnown) {
  const Json json = Json::parse(
      run_successfully(localize_with("--map " + map_of("east") + " --map " + map_of("west")) +
                       "--from-nothing --format json")
          .out);
  EXPECT_GE(json["localized"], kScans - 5);
  EXPECT_EQ(json["times_lost"], 0);
  EXPECT_GT(json["maps"][1]["localized"], 80) << "found in the second one";
  EXPECT_GT(json["maps"][0]["localized"], 40);
}

TEST(JoinedMaps, LeaveOutAMapThatIsDamaged) {
  const fs::path folder = fresh_folder();
  const std::string damaged = (folder / "damaged.slmap").string();
  std::string bytes = bytes_of(map_of("east"));
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(damaged, std::ios::binary) << bytes;
  const ProgramResult run = run_successfully(
      localize_with("--map " + map_of("west") + " --map " + damaged) + "--format json");
  EXPECT_THAT(run.err, AllOf(HasSubstr("a map cannot be read"), HasSubstr(damaged)));
  const Json json = Json::parse(run.out);
  EXPECT_GT(json["maps"][0]["localized"], 80);
  EXPECT_EQ(json["maps"][1]["localized"], 0);
  EXPECT_THAT(json["maps"][1]["fault"].get<std::string>(), StartsWith("SL4"));
  const ProgramResult none = run_sightline(localize_with("--map " + damaged));
  EXPECT_EQ(none.status, 67);
  EXPECT_THAT(none.err, HasSubstr(damaged));
}

}  // namespace
}  // namespace sightline
