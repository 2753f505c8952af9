#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kFew =
    " --set measure-error.offset_count=2 --set train-model.trees=10 --set "
    "annotation.ranges_m=10,30 --set annotation.looks=paper -q";

std::string in_town(const std::string& name) { return (compiled_town() / name).string(); }

const std::string& utm_map() {
  static const std::string kMap = [] {
    run_successfully("compile " + config_file() + " -q -o " + in_town("utm.slmap") +
                     " --set annotation.world=utm:32N");
    return in_town("utm.slmap");
  }();
  return kMap;
}

ProgramResult annotate(const std::string& map, const std::string& options) {
  return run_sightline("annotate " + map + " " + options + kFew);
}

CompiledMap read(const fs::path& file) { return value_of(read_map(file)); }

TEST(AnnotateAnew, KeepsNdsFrameAndWorldAndTakesTheSensorThatIsNamed) {
  const fs::path output = fresh_folder() / "anew.slmap";
  const ProgramResult run = annotate(utm_map(), "--route " + in_town("drive_1/poses.tum") +
                                                    " --sensor generic-32 -o " + output.string());
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("contains no surface"));
  const CompiledMap before = read(utm_map());
  const CompiledMap after = read(output);
  EXPECT_TRUE(to_bytes(before.ndt) == to_bytes(after.ndt));
  EXPECT_EQ(after.world, "utm:32N");
  EXPECT_EQ(after.sensor.name, "generic-32");
  EXPECT_EQ(after.measurement.mapping_drive, "utm.slmap");
  EXPECT_EQ(after.measurement.reference, ErrorReference::kSimulated);
  EXPECT_GT(after.sites.sites.size(), 80U);
  EXPECT_NE(after.map_id, before.map_id);
  run_successfully("verify " + output.string());
}

TEST(AnnotateAnew, TakesTheMapsOwnSensorAndFindsItsGround) {
  const fs::path output = fresh_folder() / "anew.slmap";
  const std::string line = in_town("line.csv");
  const CompiledMap before = read(utm_map());
  const Eigen::Vector3d origin_m = before.sites.frame.origin_world_m;
  std::string text = "x,y\n";
  for (const std::size_t site : {5U, 30U}) {
    const Eigen::Vector3d at_m = before.sites.sites[site].T_map_vehicle.translation() + origin_m;
    text += std::to_string(at_m.x()) + "," + std::to_string(at_m.y()) + "\n";
  }
  ASSERT_TRUE(write_file_atomically(line, text, IfExists::kReplace));
  const ProgramResult run = annotate(utm_map(), "--route " + line + " -o " + output.string());
  ASSERT_EQ(run.status, 0) << run.err;
  const CompiledMap after = read(output);
  EXPECT_TRUE(to_bytes(after.sensor) == to_bytes(before.sensor));
  ASSERT_GT(after.sites.sites.size(), 20U);
  EXPECT_NEAR(after.sites.sites.front().p_map_m.z(), before.sites.sites[5].p_map_m.z(), 0.15);
}

TEST(AnnotateAnew, EverywhereIsTheSameFromAFileAndForAnyNumberOfThreads) {
  const fs::path folder = fresh_folder();
  const CompiledMap before = read(utm_map());
  const ProgramResult run =
      annotate(utm_map(), "--route everywhere --no-cache -o " + (folder / "field.slmap").string());
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("everywhere: "));
  EXPECT_THAT(run.err, HasSubstr("separate areas are left out"));
  const CompiledMap field = read(folder / "field.slmap");
  EXPECT_TRUE(to_bytes(before.ndt) == to_bytes(field.ndt));
  EXPECT_EQ(field.sites.spacing_m, 2.0);
  EXPECT_GT(field.sites.sites.size(), 100U);
  ASSERT_TRUE(write_file_atomically(
      folder / "field.yaml", "map: " + utm_map() + "\nroute: everywhere\n", IfExists::kReplace));
  const ProgramResult again =
      run_successfully("compile " + (folder / "field.yaml").string() +
                       " --no-cache --threads 1 -o " + (folder / "again.slmap").string() + kFew);
  EXPECT_TRUE(*read_file(folder / "field.slmap") == *read_file(folder / "again.slmap"));
}

TEST(AnnotateAnew, SaysBeforehandWhatAPlaceTakesAndHowManyThereAre) {
  const ProgramResult dry =
      run_successfully("annotate " + utm_map() + " --route everywhere --dry-run");
  EXPECT_THAT(dry.out, HasSubstr("of one core per place"));
  const ProgramResult counted = run_sightline(
      "annotate " + utm_map() + " --route everywhere --no-cache --stop-after choose-field-sites");
  EXPECT_EQ(counted.status, 0) << counted.err;
  EXPECT_THAT(counted.err, HasSubstr(" of one core and "));
}

TEST(AnnotateAnew, TriesSomePlacesOnceTheyAreChosen) {
  const std::string everywhere =
      "--route everywhere --cache " + (fresh_folder() / "cache").string();
  const ProgramResult counted =
      annotate(utm_map(), everywhere + " --stop-after choose-field-sites");
  ASSERT_EQ(counted.status, 0) << counted.err;
  for (int i = 0; i < 2; ++i) {
    const ProgramResult dry = annotate(utm_map(), everywhere + " --dry-run");
    EXPECT_EQ(dry.status, 0) << dry.err;
    EXPECT_THAT(dry.out, HasSubstr(" of one core for "));
    EXPECT_THAT(dry.out, HasSubstr(" places, measured at "));
    EXPECT_THAT(dry.out, HasSubstr(" free"));
  }
}

TEST(AnnotateAnew, RefusesWhatItCannotDo) {
  const std::string route = " --route " + in_town("mapping/poses.tum");
  const std::string output = (fresh_folder() / "anew.slmap").string();
  const auto expect_refused = [&](const std::string& map, const std::string& options, int status,
                                  const std::string& mention) {
    const ProgramResult run = annotate(map, options + " --no-cache -o " + output);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_THAT(run.err, HasSubstr(mention));
    EXPECT_FALSE(fs::exists(output));
  };
  expect_refused(utm_map(), route + " --world utm:33N", 64, "utm:32N");
  expect_refused(utm_map(), route + " --set map.height_m=2.0", 64, "map.sensor");
  expect_refused(in_town("mapping/scans"), route, 64, "--sensor is required");
  expect_refused(utm_map(), " --route everywhere --set choose-field-sites.most_places=5", 65,
                 "SL2028 too-many-places");
  const std::string cut = in_town("cut.slmap");
  std::string bytes = *read_text_file(utm_map());
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file_atomically(cut, bytes, IfExists::kReplace));
  expect_refused(cut, route, 67, "SL4");
  // No points are left to be exported, or to be looked at.
  ASSERT_TRUE(write_file_atomically(in_town("anew.yaml"), "map: utm.slmap\nroute: everywhere\n",
                                    IfExists::kReplace));
  const ProgramResult exported = run_sightline("export " + in_town("anew.yaml") +
                                               " -q --format pcd -o " + in_town("points.pcd"));
  EXPECT_EQ(exported.status, 64) << exported.err;
  const ProgramResult dumped = run_sightline("dump " + in_town("anew.yaml") + " -q --what points");
  EXPECT_NE(dumped.status, 0);
  EXPECT_THAT(dumped.err, HasSubstr("makes no points"));
}

}  // namespace
}  // namespace sightline
