#include "compiler/driver/model_source.h"

#include <gmock/gmock.h>

#include <fstream>

#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "formats/text/table.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kShipped =
    std::filesystem::path(SIGHTLINE_ROOT) / "passes/model/shipped/generated.slmodel";

CompileConfig of_drives() {
  CompileConfig config;
  config.mapping.scans = "scans";
  return config;
}

TEST(ModelSource, TheModelThatComesWithTheProgramLiesBesideIt) {
  EXPECT_EQ(shipped_model("/usr/bin/sightline"), "/usr/share/sightline/models/generated.slmodel");
}

TEST(ModelSource, AGivenModelIsUsedWhateverTheConfigurationNames) {
  CompileConfig config = of_drives();
  config.annotation.model = DefaultModel::kOwn;
  const ChosenModel chosen = value_of(choose_model(config, "city.slmodel", kShipped));
  EXPECT_EQ(chosen.file, "city.slmodel");
  EXPECT_EQ(chosen.source(), ModelSource::kGiven);
}

TEST(ModelSource, WithoutAGivenModelItIsTheOneOfGeneratedWorlds) {
  EXPECT_EQ(value_of(choose_model(of_drives(), "", kShipped)).file, kShipped);
}

TEST(ModelSource, AConfigurationCanTurnItOff) {
  CompileConfig config = of_drives();
  config.annotation.model = DefaultModel::kOwn;
  const ChosenModel chosen = value_of(choose_model(config, "", "missing.slmodel"));
  EXPECT_EQ(chosen.source(), ModelSource::kTrained);
  EXPECT_EQ(chosen.why_own, "");
}

TEST(ModelSource, AFinishedMapIsAnnotatedWithoutIt) {
  CompileConfig config = of_drives();
  config.map.points = "map.pcd";
  EXPECT_EQ(value_of(choose_model(config, "", kShipped)).source(), ModelSource::kTrained);
}

TEST(ModelSource, ItIsNotUsedForOtherRangesLooksLimitsOrLocalizers) {
  const auto why = [](const auto& change) {
    CompileConfig config = of_drives();
    change(config);
    const ChosenModel chosen = value_of(choose_model(config, "", kShipped));
    EXPECT_EQ(chosen.source(), ModelSource::kTrained);
    return chosen.why_own;
  };
  EXPECT_THAT(why([](CompileConfig& c) {
                c.annotation.ranges_m = {10.0, 30.0};
              }),
              HasSubstr("other ranges"));
  EXPECT_THAT(why([](CompileConfig& c) { c.annotation.looks.pop_back(); }),
              HasSubstr("other looks"));
  EXPECT_THAT(why([](CompileConfig& c) { c.annotation.limits_m = {0.2}; }),
              HasSubstr("other limits"));
  EXPECT_THAT(why([](CompileConfig& c) { c.outside.file = "errors.csv"; }),
              HasSubstr("another localizer"));
  EXPECT_THAT(why([](CompileConfig& c) { c.passes.own["emit-map"]["size"] = "promise"; }),
              HasSubstr("full maps"));
}

TEST(ModelSource, AModelOfFullMapsIsRefusedForASmallMap) {
  CompileConfig config = of_drives();
  config.passes.own["emit-map"]["size"] = "promise";
  ArtifactSet artifacts;
  const Result<void> small =
      provide_model(compile_plan(config, ModelSource::kGiven), kShipped, artifacts);
  ASSERT_FALSE(small.has_value());
  EXPECT_EQ(small.error().code, ErrorCode::kMismatchedInputs);
  EXPECT_THAT(small.error().message, HasSubstr("emit-map.size=promise"));
  EXPECT_TRUE(provide_model(compile_plan(of_drives(), ModelSource::kGiven), kShipped, artifacts));
}

TEST(ModelSource, AMissingModelIsAnErrorThatNamesTheRemedy) {
  const Result<ChosenModel> chosen = choose_model(of_drives(), "", "missing.slmodel");
  ASSERT_FALSE(chosen.has_value());
  EXPECT_EQ(chosen.error().code, ErrorCode::kFileNotFound);
  EXPECT_THAT(chosen.error().message, HasSubstr("annotation.model=own"));
}

TEST(ModelSource, TheShippedModelIsSmallAndOfGeneratedWorlds) {
  EXPECT_LE(std::filesystem::file_size(kShipped), std::uintmax_t{2} << 20);
  const ByFamily<ErrorModel> model = value_of(read_model(kShipped));
  EXPECT_TRUE(model.ranges.card.is_of_generated_worlds());
  ASSERT_TRUE(model.samples.has_value());
  EXPECT_TRUE(model.samples->card.is_of_generated_worlds());
  EXPECT_GE(model.ranges.card.block_count, 40U);
}

TEST(ModelSource, ADamagedPackedModelIsRefused) {
  std::filesystem::create_directories(scratch_folder());
  const std::filesystem::path damaged = scratch_folder() / "damaged.slmodel";
  std::filesystem::copy_file(kShipped, damaged, std::filesystem::copy_options::overwrite_existing);
  std::filesystem::permissions(damaged, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::add);
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  EXPECT_FALSE(read_model(damaged).has_value());
  std::filesystem::remove(damaged);
}

}  // namespace
}  // namespace sightline
