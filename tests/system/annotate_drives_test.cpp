#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

// A finished map that was annotated without a drive gets drives one after another: what they
// measured is history where they passed, and nothing that was known before is thrown away.

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double kHistory_m = 6.0;  // schemas/definitions.md, "Measured history"

// Sites every 1.3 m, so that none is one that the model learnt at.
std::string config(const std::string& drives, const std::string& spacing) {
  return "annotation: {ranges_m: [10, 30], looks: paper}\n"
         "map: {points: points, sensor: generic-16}\nroute: {file: mapping/poses.tum}\n"
         "choose-route-sites: {spacing_m: " +
         spacing + "}\nmeasure-error: {offset_count: 2, reference: known}\n" +
         "train-model: {trees: 10}\n" + drives;
}

constexpr const char* kFirst =
    "localization:\n- {scans: drive_1/scans, poses: drive_1/poses.tum}\n";
constexpr const char* kSecond = "- {scans: drive_2/scans, poses: drive_2/poses.tum}\n";

constexpr const char* kFromCompiled =
    "annotation: {ranges_m: [10, 30], looks: paper}\n"
    "map: {points: first.slmap, sensor: generic-16}\nroute: {file: mapping/poses.tum}\n"
    "choose-route-sites: {spacing_m: 1.3}\nmeasure-error: {offset_count: 2, reference: known}\n"
    "train-model: {trees: 10}\n";

struct Maps {
  CompiledMap without;     // any drive
  CompiledMap with_first;  // which drove the first half
  CompiledMap with_both;   // the second drove all
  CompiledMap anew;        // from the map with the first drive, without any drive
  CompiledMap anew_with_second;
};

CompiledMap read(const fs::path& file) { return value_of(read_map(file)); }

const Maps& maps() {
  static const Maps kMaps = [] {
    const fs::path town = scratch_folder() / "driven";
    make_town(town, "--seed 3 --length-m 80 --drives 2 --part 1,0,35");
    const auto write = [&](const std::string& name, const std::string& text) {
      EXPECT_TRUE(write_file_atomically(town / name, text, IfExists::kReplace));
      return (town / name).string();
    };
    run_successfully(
        "export " +
        write("town.yaml", "mapping: {scans: mapping/scans, poses: mapping/poses.tum}\n") +
        " -q --format autoware --world enu:48.98,8.39,0 -o " + (town / "points").string());
    const std::string model = (town / "own.slmodel").string();
    run_successfully("train " + write("learnt.yaml", config(std::string(kFirst) + kSecond, "1")) +
                     " -q -o " + model);
    Maps maps;
    const auto annotated = [&](const std::string& name, const std::string& drives) {
      const fs::path file = town / (name + ".slmap");
      run_successfully("compile " + write(name + ".yaml", config(drives, "1.3")) + " -q --model " +
                       model + " -o " + file.string());
      return read(file);
    };
    maps.without = annotated("without", "");
    maps.with_first = annotated("first", kFirst);
    maps.with_both = annotated("both", std::string(kFirst) + kSecond);
    const auto annotated_anew = [&](const std::string& name, const std::string& more) {
      const fs::path file = town / (name + ".slmap");
      std::string config = kFromCompiled;
      run_successfully("compile " + write(name + ".yaml", config + more) + " -q --model " + model +
                       " -o " + file.string());
      return read(file);
    };
    maps.anew = annotated_anew("anew", "");
    maps.anew_with_second =
        annotated_anew("anew_with_second", std::string("localization:\n") + kSecond);
    return maps;
  }();
  return kMaps;
}

std::size_t column(const FactorTable& factors, const std::string& name) {
  const auto found = std::ranges::find(factors.factors, name);
  EXPECT_NE(found, factors.factors.end()) << name;
  return static_cast<std::size_t>(found - factors.factors.begin());
}

bool is_simulated(const CompiledMap& map, std::size_t site) {
  return (map.ranges.flags_of(site, 0) & kSimulatedAnswer) != 0;
}

TEST(AnnotateDrives, AreHistoryWherePassedAndElsewhereTheMapStaysAsItWas) {
  const CompiledMap& before = maps().without;
  const CompiledMap& after = maps().with_first;
  ASSERT_EQ(before.sites.sites.size(), after.sites.sites.size());
  ASSERT_GT(before.sites.sites.size(), 50U);
  std::size_t with_history = 0;
  for (std::size_t site = 0; site < after.sites.sites.size(); ++site) {
    EXPECT_EQ(before.predicted.has_history[site], 0);
    // Where the routes begin the model learnt at this very site.
    EXPECT_EQ(is_simulated(before, site), before.predicted.out_of_fold[site] == 0) << site;
    const double s_m = after.sites.sites[site].s_m;
    const bool has_history = after.predicted.has_history[site] == 1;
    with_history += has_history ? 1 : 0;
    EXPECT_EQ(is_simulated(after, site), !has_history) << s_m;
    EXPECT_TRUE(has_history || s_m >= 33.0) << s_m;
    if (s_m < 37.0 + kHistory_m) continue;
    EXPECT_FALSE(has_history) << s_m;
    for (std::size_t look = 0; look < after.predicted.looks.size(); ++look) {
      EXPECT_EQ(after.predicted.mean(site, look), before.predicted.mean(site, look)) << s_m;
    }
  }
  EXPECT_GT(with_history, 20U);
  EXPECT_LT(with_history, after.sites.sites.size());
}

TEST(AnnotateDrives, ThrowNothingAwayThatWasKnownBefore) {
  const FactorTable& without = maps().without.factors;
  const FactorTable& first = maps().with_first.factors;
  const FactorTable& both = maps().with_both.factors;
  std::vector<std::string> of_first = without.factors;
  for (const char* name : {"measured_mean_m", "measured_p90_m", "measured_lost_share"}) {
    of_first.emplace_back(name);
  }
  EXPECT_EQ(first.factors, of_first);
  for (std::size_t site = 0; site < both.site_count; ++site) {
    for (std::size_t look = 0; look < both.looks.size(); ++look) {
      for (const std::string& name : without.factors) {
        const double known = without.at(site, look, column(without, name));
        EXPECT_EQ(first.at(site, look, column(first, name)), known) << name << " at " << site;
        EXPECT_EQ(both.at(site, look, column(both, name)), known) << name << " at " << site;
      }
      const std::size_t measured = column(first, "measured_mean_m");
      EXPECT_EQ(both.at(site, look, column(both, "measured_mean_m")),
                first.at(site, look, measured));
    }
  }
  EXPECT_EQ(std::ranges::count(maps().with_both.predicted.has_history, std::uint8_t{1}),
            std::ssize(maps().with_both.predicted.has_history));
  EXPECT_GE(both.at(both.site_count - 1, 0, column(both, "measured_mean_m[2]")), 0.0);
}

// [site]: what a drive measured there at the shortest range, -1 where nothing.
std::vector<double> measured_of(const CompiledMap& map, const std::string& drive) {
  const std::size_t mean = column(map.factors, "measured_mean_m" + drive);
  std::vector<double> found;
  for (std::size_t site = 0; site < map.factors.site_count; ++site) {
    found.push_back(map.factors.at(site, 0, mean));
  }
  return found;
}

TEST(AnnotateDrives, StayHistoryWhereTheCompiledMapIsAnnotatedAnew) {
  const CompiledMap& first = maps().with_first;
  const CompiledMap& anew = maps().anew;
  ASSERT_EQ(anew.sites.sites.size(), first.sites.sites.size());
  EXPECT_EQ(measured_of(anew, ""), measured_of(first, ""));
  EXPECT_EQ(anew.predicted.has_history, first.predicted.has_history);
  for (std::size_t site = 0; site < anew.sites.sites.size(); ++site) {
    EXPECT_EQ(is_simulated(anew, site), is_simulated(first, site)) << site;
  }
  const CompiledMap& both = maps().anew_with_second;
  EXPECT_EQ(measured_of(both, "[2]"), measured_of(first, ""));
  EXPECT_EQ(std::ranges::count(measured_of(both, ""), -1.0), 0);
  EXPECT_EQ(std::ranges::count(both.predicted.has_history, std::uint8_t{1}),
            std::ssize(both.predicted.has_history));
}

TEST(AnnotateDrives, AreNamedWhereTheMapThatIsMadeAnewCannotTellThem) {
  const fs::path town = scratch_folder() / "driven";
  maps();
  const std::string output = (town / "learnt_anew.slmap").string();
  const ProgramResult learnt =
      run_successfully("compile " + (town / "anew.yaml").string() + " -q -o " + output);
  EXPECT_THAT(learnt.err,
              testing::HasSubstr("errors that drives measured in the earlier map are not used"));
  const ProgramResult other =
      run_successfully("compile " + (town / "anew.yaml").string() + " -q --force --model " +
                       (town / "own.slmodel").string() + " --set map.sensor=hdl-32e -o " + output);
  EXPECT_THAT(other.err, testing::HasSubstr("are not used: its sensor was generic-16"));
}

}  // namespace
}  // namespace sightline
