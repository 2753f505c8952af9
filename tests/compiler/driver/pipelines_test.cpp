#include "compiler/driver/pipelines.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "compiler/pipeline/schedule.h"

namespace sightline {
namespace {

RecordingOptions drive(const std::string& name) {
  RecordingOptions options;
  options.scans = name;
  return options;
}

// Drives by the names of their recordings, in the order of the configuration.
CompileConfig config_of(const std::vector<std::string>& mapping,
                        const std::vector<std::string>& localization) {
  CompileConfig config;
  config.mapping = drive(mapping.front());
  for (std::size_t i = 1; i < mapping.size(); ++i) {
    config.later_mapping.push_back(drive(mapping[i]));
  }
  config.localization = drive(localization.front());
  for (std::size_t i = 1; i < localization.size(); ++i) {
    config.later_localization.push_back(drive(localization[i]));
  }
  return config;
}

// Keys of the steps of a compile, by the name of the step. The content of a recording is its name.
class Keys {
 public:
  Keys(const std::vector<std::string>& mapping, const std::vector<std::string>& localization) {
    const CompilePlan compile = compile_plan(config_of(mapping, localization));
    ArtifactSet artifacts;
    for (const RecordingInput& input : compile.recordings) {
      artifacts.provide(input.recording, Recording{}, sha256(input.options.scans));
      artifacts.provide(input.sensor, SensorProfile{});
      drives_.emplace_back(input.role, input.options.scans);
    }
    artifacts.provide(compile.cards, RecordingCards{});
    for (const PlannedRun& run : planned_runs(compile.plan, {}, {}, artifacts)) {
      keys_[run.name] = run.key;
    }
  }

  [[nodiscard]] Digest of(const std::string& step) const { return keys_.at(step); }
  // That of a pass on the drive of that recording; its first step has no label.
  [[nodiscard]] Digest of(const std::string& pass, const std::string& recording) const {
    for (const auto& [role, scans] : drives_) {
      if (scans != recording) continue;
      const auto found = keys_.find(pass + ":" + role);
      return found != keys_.end() ? found->second : keys_.at(pass);
    }
    ADD_FAILURE() << recording << " is no drive of this compile";
    return {};
  }
  [[nodiscard]] std::set<Digest> all() const {
    std::set<Digest> all;
    for (const auto& [step, key] : keys_) all.insert(key);
    return all;
  }
  [[nodiscard]] std::size_t count() const { return keys_.size(); }

 private:
  std::vector<std::pair<std::string, std::string>> drives_;  // role and recording
  std::map<std::string, Digest> keys_;
};

TEST(CompilePlan, KeepsTheKeysOfADriveThatAnotherIsAddedBefore) {
  const Keys before({"a", "b"}, {"x"});
  const Keys after({"new", "a", "b"}, {"x"});
  EXPECT_EQ(after.of("ingest", "a"), before.of("ingest", "a"));
  EXPECT_EQ(after.of("ingest", "b"), before.of("ingest", "b"));
  for (const char* pass : {"ingest", "estimate-trajectory", "undistort-scans"}) {
    EXPECT_EQ(after.of(pass, "x"), before.of(pass, "x")) << pass;
  }
  EXPECT_NE(after.of("estimate-trajectory"), before.of("estimate-trajectory"));
  EXPECT_NE(after.of("build-ndt"), before.of("build-ndt"));
  EXPECT_NE(after.of("align-drive", "x"), before.of("align-drive", "x"));
}

TEST(CompilePlan, KeepsTheKeysOfLocalizationDrivesInAnotherOrder) {
  const Keys before({"a"}, {"x", "y", "z"});
  const Keys after({"a"}, {"x", "z", "y"});
  for (const char* pass :
       {"ingest", "estimate-trajectory", "undistort-scans", "align-drive", "measure-error"}) {
    for (const char* recording : {"x", "y", "z"}) {
      EXPECT_EQ(after.of(pass, recording), before.of(pass, recording)) << pass << " " << recording;
    }
  }
  EXPECT_NE(after.of("pool-errors"), before.of("pool-errors")) << "drives take sites in turn";
}

TEST(CompilePlan, TellsALaterLocalizationDriveFromTheFirst) {
  const Keys one({"a"}, {"x", "y"});
  const Keys other({"a"}, {"y", "x"});
  EXPECT_EQ(other.of("undistort-scans", "x"), one.of("undistort-scans", "x"));
  EXPECT_NE(other.of("align-drive", "x"), one.of("align-drive", "x"));
  EXPECT_NE(other.of("measure-error", "x"), one.of("measure-error", "x"));
}

TEST(CompilePlan, OfTheOtherOrderOfMappingDrivesIsAnotherMap) {
  const Keys one({"a", "b"}, {"x"});
  const Keys other({"b", "a"}, {"x"});
  EXPECT_EQ(other.of("ingest", "a"), one.of("ingest", "a"));
  EXPECT_NE(other.of("build-ndt"), one.of("build-ndt"));
  EXPECT_NE(other.of("emit-map"), one.of("emit-map"));
}

TEST(CompilePlan, HasAKeyForEachStep) {
  const Keys keys({"a", "b", "c"}, {"x", "y", "z"});
  EXPECT_EQ(keys.all().size(), keys.count());
}

}  // namespace
}  // namespace sightline
