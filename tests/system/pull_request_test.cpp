#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "formats/text/quoted_text.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"
#include "tests/system/program.h"

// Pull requests against a released map: the same town recorded again, and recorded after something
// made a stretch of it worse. One model of other towns judges both maps, so that nothing but the
// street differs. In the first half of the stretch 10 to 20 m were
// enough before.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;
const fs::path kRoot = SIGHTLINE_ROOT;
constexpr double kChangeFrom_m = 100.0;
constexpr double kChangeTo_m = 200.0;

constexpr const char* kConfig = R"(
annotation:
  ranges_m: [10, 20, 30, 50]
  split: auto
  looks:
    - 100 m, 650 returns, evenly spaced beyond 30 m, 40 points by normals
    - 100 m, 4000 returns, evenly spaced beyond 50 m, 128 points by normals
mapping: {name: town-mapping, scans: mapping/scans, poses: mapping/poses.tum, sensor: generic-16}
localization: {name: town-drive-1, scans: drive_1/scans, poses: drive_1/poses.tum, sensor: generic-16}
measure-error: {offset_count: 5, reference: known}
train-model: {trees: 60}
gate:
  rules:
    extrapolated-share: 0.75  # the model is of three streets
)";

fs::path town(const std::string& name, const std::string& options) {
  const fs::path folder = scratch_folder() / name;
  make_town(folder, "--length-m 300 --drives 1 " + options);
  EXPECT_TRUE(write_file_atomically(folder / "town.yaml", kConfig, IfExists::kReplace));
  return folder;
}

const std::string& model() {
  static const std::string kModel = [] {
    std::string configs;
    for (const char* seed : {"5", "6", "7"}) {
      configs += (town(std::string("known_") + seed, std::string("--seed ") + seed) / "town.yaml ")
                     .string();
    }
    const std::string file = (scratch_folder() / "towns.slmodel").string();
    run_successfully("train -q " + configs + " -o " + file);
    return file;
  }();
  return kModel;
}

// What examples/ci/run makes of a town in its folder map/, as a job of GitHub Actions.
struct Pipeline {
  fs::path out;
  int status = 0;
  std::string said;  // text and annotations of the gate, among others
  std::string markdown, junit;
  Json json, sarif;

  [[nodiscard]] std::string map() const { return (out / "map.slmap").string(); }
};

struct Job {
  fs::path folder;
  std::string release;  // empty: the first map
  std::string model;    // empty: each map trains its own
  std::string steps = "compile gate";
};

Pipeline run_pipeline(const Job& job) {
  Pipeline pipeline;
  pipeline.out = job.folder / (job.model.empty() ? "map_alone" : "map");
  const ProgramResult run = run_command(
      "GITHUB_ACTIONS=true MAP_CONFIG=" + (job.folder / "town.yaml").string() +
      " MAP_OUT=" + pipeline.out.string() + " MAP_CACHE=" + (job.folder / "cache").string() +
      " MAP_RELEASE=" + job.release + " MAP_MODEL=" + job.model +
      " SIGHTLINE=" SIGHTLINE_PROGRAM " " + (kRoot / "examples/ci/run").string() + " " + job.steps);
  pipeline.status = run.status;
  pipeline.said = run.out;
  pipeline.markdown = bytes_of(pipeline.out / "gate.md");
  pipeline.junit = bytes_of(pipeline.out / "gate.junit.xml");
  pipeline.json = Json::parse(bytes_of(pipeline.out / "gate.json"));
  pipeline.sarif = Json::parse(bytes_of(pipeline.out / "gate.sarif"));
  return pipeline;
}

const fs::path& released_town() {
  static const fs::path kTown = town("released", "--seed 9");
  return kTown;
}

std::string first_map(const std::string& model_file) {
  const Pipeline first =
      run_pipeline({.folder = released_town(), .release = "", .model = model_file});
  EXPECT_EQ(first.status, 0) << first.said;
  return first.map();
}

const std::string& release() {
  static const std::string kMap = first_map(model());
  return kMap;
}

void expect_valid_forms(const Pipeline& judged) {
  const auto schema = [](const char* file) { return Json::parse(bytes_of(kRoot / file)); };
  EXPECT_EQ(schema_faults(schema("schemas/gate.schema.json"), judged.json), "");
  EXPECT_EQ(
      schema_faults(schema("tests/compiler/gate/schemas/sarif-2.1.0-rtm.5.json"), judged.sarif),
      "");
  const ProgramResult xml = run_command("xmllint --noout --nonet --schema '" +
                                        (kRoot / "tests/compiler/gate/schemas/JUnit.xsd").string() +
                                        "' '" + (judged.out / "gate.junit.xml").string() + "'");
  EXPECT_EQ(xml.status, 0) << xml.err;
}

std::vector<Json> violations(const Pipeline& judged, const std::string& severity) {
  std::vector<Json> found;
  for (const Json& check : judged.json.at("checks")) {
    if (check.at("verdict") == "violated" && check.at("severity") == severity)
      found.push_back(check);
  }
  return found;
}

void expect_in_every_form(const Pipeline& judged, const Json& check) {
  const std::string rule = check.at("rule");
  const std::string message = check.at("message");
  const Json& place = check.at("place");
  const std::string sites =
      "sites " + place.at("first_site").dump() + " to " + place.at("last_site").dump();
  EXPECT_THAT(message, HasSubstr(sites + " (run 0, "));
  EXPECT_THAT(message, HasSubstr(" m in the world)"));
  EXPECT_THAT(judged.said, HasSubstr("  [" + rule + "] " + message + "\n"));
  EXPECT_THAT(judged.said, HasSubstr(",title=" + rule + "::"));
  EXPECT_THAT(judged.said, HasSubstr("::" + sites));
  EXPECT_THAT(judged.markdown, HasSubstr("| error | `" + rule + "` |"));
  EXPECT_THAT(judged.markdown, HasSubstr("| " + sites + " |"));
  EXPECT_THAT(judged.markdown, HasSubstr(message));
  EXPECT_THAT(judged.junit, HasSubstr("<failure type=\"" + rule + "\""));
  EXPECT_THAT(judged.junit, HasSubstr(xml_text(message)));
  const Json& results = judged.sarif.at("runs").at(0).at("results");
  EXPECT_TRUE(std::ranges::any_of(results, [&](const Json& result) {
    return result.at("ruleId") == rule && result.at("message").at("text") == message &&
           result.at("level") == "error" &&
           result.at("properties").at("found") == check.at("found") &&
           result.at("properties").at("middle_world_m") == place.at("middle_world_m");
  })) << message;
}

bool meets_the_change(const Json& check) {
  const Json& place = check.at("place");
  return place.at("first_s_m") <= kChangeTo_m && place.at("last_s_m") >= kChangeFrom_m;
}

// From beside the change a vehicle still sees it, no farther than it sees at all.
bool sees_the_change(const Json& check) {
  constexpr double kSight_m = 50.0;
  const Json& place = check.at("place");
  return place.at("first_s_m") >= kChangeFrom_m - kSight_m &&
         place.at("last_s_m") <= kChangeTo_m + kSight_m;
}

std::vector<double> ranges_within_10_cm(const std::string& map) {
  const ProgramResult run = run_successfully("dump " + map + " --what ranges --format json");
  const Json table = Json::parse(run.out);
  const Json& columns = table.at("columns");
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
  };
  std::vector<double> ranges_m;
  for (const Json& row : table.at("rows")) {
    if (row.at(column("limit_m")) == 0.1) ranges_m.push_back(row.at(column("range_m")));
  }
  return ranges_m;
}

// The worst mean rise over 20 m that the place touches, from the numbers of the two maps alone.
double worst_rise_m(const std::string& before, const std::string& after, const Json& place) {
  const std::vector<double> before_m = ranges_within_10_cm(before);
  const std::vector<double> after_m = ranges_within_10_cm(after);
  EXPECT_EQ(before_m.size(), after_m.size());
  double worst_m = 0.0;
  for (std::size_t first = 0; first + 20 < after_m.size(); ++first) {
    if (first > place.at("last_site") || first + 20 < place.at("first_site")) continue;
    double sum_m = 0.0;
    for (std::size_t site = first; site <= first + 20; ++site)
      sum_m += after_m[site] - before_m[site];
    worst_m = std::max(worst_m, sum_m / 21.0);
  }
  return worst_m;
}

void expect_failed(const Pipeline& judged) {
  EXPECT_EQ(judged.status, 69) << judged.said;
  EXPECT_EQ(judged.json.at("passed"), false);
  EXPECT_THAT(judged.said, HasSubstr("\nGate: failed, "));
  EXPECT_THAT(judged.said, HasSubstr("::error title=sightline gate::failed"));
  EXPECT_THAT(judged.markdown, HasSubstr("### sightline gate: failed\n"));
  expect_valid_forms(judged);
}

void expect_refused_for_its_ranges(const Job& job) {
  const Pipeline judged = run_pipeline(job);
  expect_failed(judged);
  bool looks_farther = false;
  for (const Json& check : violations(judged, "error")) {
    if (check.at("place").is_null()) continue;
    EXPECT_TRUE(sees_the_change(check)) << check;
    EXPECT_GT(check.at("found"), check.at("allowed"));
    expect_in_every_form(judged, check);
    if (check.at("rule") != "stretch-range-rise" || check.at("limit_m") != 0.1) continue;
    looks_farther |= meets_the_change(check);
    EXPECT_NEAR(check.at("found"), worst_rise_m(job.release, judged.map(), check.at("place")),
                1e-9);
  }
  EXPECT_TRUE(looks_farther) << judged.said;
}

// Eight compiles of a street of 300 m.
class PullRequest : public ::testing::Test {
  void SetUp() override {
    if (std::getenv("SIGHTLINE_LONG") == nullptr) GTEST_SKIP() << "SIGHTLINE_LONG is not set";
  }
};

TEST_F(PullRequest, ThatChangesNothingPasses) {
  const fs::path& before = released_town();
  const fs::path again = scratch_folder() / "again";
  fs::create_directories(again);
  for (const char* part : {"mapping", "drive_1"}) {
    fs::create_directory_symlink(before / part, again / part);
  }
  fs::copy_file(before / "town.yaml", again / "town.yaml");
  const Pipeline judged = run_pipeline({again, release(), model(), "compile diff gate"});
  EXPECT_EQ(judged.status, 0) << judged.said;
  EXPECT_THAT(bytes_of(judged.out / "diff.md"), HasSubstr("The maps are the same."));
  EXPECT_EQ(judged.json.at("passed"), true);
  EXPECT_EQ(judged.json.at("map").at("root_digest"), judged.json.at("old_map").at("root_digest"));
  EXPECT_TRUE(violations(judged, "error").empty());
  EXPECT_THAT(judged.junit, HasSubstr(" failures=\"0\""));
  expect_valid_forms(judged);
}

fs::path changed_town(const std::string& kind, const std::string& more = "") {
  return town(kind, "--seed 9 --change 100,200 --change-only " + kind + more);
}

void expect_diff_finds_the_change(const std::string& before, const std::string& after) {
  const ProgramResult run = run_sightline("diff " + before + " " + after + " --format json");
  EXPECT_EQ(run.status, 1) << run.err;
  const Json stretches = Json::parse(run.out).at("stretches");
  EXPECT_TRUE(std::ranges::any_of(stretches, [](const Json& stretch) {
    return stretch.at("has_changed_place") && stretch.at("begin_s_m") <= kChangeTo_m &&
           stretch.at("end_s_m") >= kChangeFrom_m;
  })) << stretches;
}

// The longest front is gone, and what is left holds a vehicle as well: 66 % of the changed stretch
// are within 10 cm at 10 m before and after, 89 and 89 % at 20 m.
TEST_F(PullRequest, ThatTakesAWallAwayPassesWhereNothingWasMeasuredWorse) {
  const Job job = {changed_town("wall"), release(), model(), "all"};
  const Pipeline judged = run_pipeline(job);
  EXPECT_EQ(judged.status, 0) << judged.said;
  expect_valid_forms(judged);
  expect_diff_finds_the_change(job.release, judged.map());
  EXPECT_THAT(bytes_of(judged.out / "diff.md"), HasSubstr("| run 0,"));
  EXPECT_THAT(bytes_of(judged.out / "report.html"), HasSubstr("<h1>"));
}

// They hide the walls from near: at 10 m 44 instead of 66 % of the first half are within 10 cm. The
// model of three towns does not see that, the drive did.
TEST_F(PullRequest, WithTenMoreParkedCarsIsRefusedForWhatWasMeasured) {
  const Pipeline judged = run_pipeline({changed_town("cars"), release(), model(), "all"});
  expect_failed(judged);
  EXPECT_TRUE(std::ranges::any_of(violations(judged, "error"), [](const Json& check) {
    return check.at("rule") == "measured-coverage-drop" && check.at("limit_m") == 0.1;
  })) << judged.said;
  EXPECT_THAT(bytes_of(judged.out / "diff.md"), HasSubstr("| run 0,"));
  EXPECT_THAT(bytes_of(judged.out / "report.html"), HasSubstr("<h1>"));
}

TEST_F(PullRequest, WithNoisierScansIsRefused) {
  expect_refused_for_its_ranges({changed_town("noise", " --change-noise 10"), release(), model()});
}

}  // namespace
}  // namespace sightline
