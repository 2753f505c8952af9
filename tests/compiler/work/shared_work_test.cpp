#include "compiler/work/shared_work.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

PlanFile some_plan() {
  PlanFile plan;
  plan.folder = "/maps";
  plan.configuration = "/maps/city \"1\".yaml";
  plan.overrides = {"train-model.trees=20", "annotation.seed=7"};
  plan.model = "/maps/city.slmodel";
  plan.values = std::string(64, '0');
  plan.recordings = {{"mapping", std::string(64, 'a')}, {"localization", std::string(64, 'b')}};
  return plan;
}

class PlanFileTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Result<PlanFile> read(const std::string& text) {
    EXPECT_TRUE(write_file_atomically(plan_file_in(folder_), text, IfExists::kReplace));
    return read_plan_file(folder_);
  }
  ErrorCode failure(const std::string& text) {
    const Result<PlanFile> plan = read(text);
    EXPECT_FALSE(plan.has_value());
    return plan ? ErrorCode{} : plan.error().code;
  }

  const std::filesystem::path folder_ = scratch_folder();
};

TEST_F(PlanFileTest, IsReadBackAsItWasWritten) {
  const PlanFile plan = some_plan();
  const Result<PlanFile> read_back = read(to_json(plan));
  ASSERT_TRUE(read_back.has_value()) << to_string(read_back.error());
  EXPECT_EQ(read_back->folder, plan.folder);
  EXPECT_EQ(read_back->configuration, plan.configuration);
  EXPECT_EQ(read_back->overrides, plan.overrides);
  EXPECT_EQ(read_back->model, plan.model);
  EXPECT_EQ(read_back->values, plan.values);
  EXPECT_EQ(read_back->recordings, plan.recordings);
}

TEST_F(PlanFileTest, KeepsToItsSchema) {
  using Json = nlohmann::json;
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/plan.schema.json"));
  Json plan = Json::parse(to_json(some_plan()));
  EXPECT_EQ(schema_faults(schema, plan), "");
  plan["values"] = "short";
  EXPECT_NE(schema_faults(schema, plan), "");
}

TEST_F(PlanFileTest, IsRefusedWhereItIsNone) {
  EXPECT_EQ(read_plan_file(folder_).error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(failure(""), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("[1, 2]"), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("{\"map\": 1}"), ErrorCode::kMalformedText);
  EXPECT_EQ(failure("{\"sightline_plan\": 2}"), ErrorCode::kFutureVersion);
  EXPECT_EQ(failure("{\"sightline_plan\": \"1\"}"), ErrorCode::kFutureVersion);
  EXPECT_EQ(failure("{\"sightline_plan\": 1}"), ErrorCode::kMissingKey);
  std::string text = to_json(some_plan());
  const std::size_t digest = text.find("\"aaaa");
  ASSERT_NE(digest, std::string::npos);
  EXPECT_EQ(failure(text.replace(digest, 66, "17")), ErrorCode::kMissingKey);
}

}  // namespace
}  // namespace sightline
