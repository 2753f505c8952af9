#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <regex>
#include <set>

namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
const std::string kFolder = std::string(SIGHTLINE_ROOT) + "/examples/ci";

std::string text_of(const std::string& file) {
  std::ifstream stream(kFolder + "/" + file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::set<std::string> matches_in(const std::string& file, const std::string& pattern) {
  const std::string text = text_of(file);
  const std::regex named(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), named), end; at != end; ++at) {
    found.insert((*at)[1]);
  }
  return found;
}

std::set<std::string> steps_of_script() { return matches_in("run", "\nstep_([a-z]+)\\(\\)"); }

std::set<std::string> steps_called_in(const std::string& file) {
  std::set<std::string> steps = matches_in(file, "ci/run ([a-z]+)");
  steps.erase("into");  // in the comment on where the script goes
  return steps;
}

TEST(CiExample, BothPipelinesCallEveryStepThatDecides) {
  const std::set<std::string> known = steps_of_script();
  for (const std::string file : {"github.yml", "gitlab.yml"}) {
    const std::set<std::string> called = steps_called_in(file);
    for (const std::string& step : called) EXPECT_THAT(known, Contains(step)) << file;
    for (const char* step : {"compile", "evaluate", "diff", "report", "gate"}) {
      EXPECT_THAT(called, Contains(step)) << file;
    }
  }
}

TEST(CiExample, GithubWorkflowHasJobsOfStepsThatRunOrUse) {
  const YAML::Node workflow = YAML::LoadFile(kFolder + "/github.yml");
  EXPECT_TRUE(workflow["on"]["pull_request"].IsDefined());
  EXPECT_TRUE(workflow["on"]["push"].IsDefined());
  ASSERT_TRUE(workflow["jobs"].IsMap());
  std::string uses;
  for (const auto& job : workflow["jobs"]) {
    EXPECT_TRUE(job.second["runs-on"].IsScalar());
    std::set<std::string> ids;
    for (const YAML::Node& step : job.second["steps"]) {
      EXPECT_NE(step["run"].IsDefined(), step["uses"].IsDefined()) << "either runs or uses";
      if (step["uses"]) {
        EXPECT_TRUE(std::regex_match(step["uses"].Scalar(), std::regex("[\\w/-]+@v\\d+")))
            << step["uses"].Scalar();
        uses += step["uses"].Scalar() + " ";
      }
      if (step["id"]) {
        EXPECT_TRUE(ids.insert(step["id"].Scalar()).second);
      }
      for (const auto& key : step) {
        EXPECT_THAT((std::set<std::string>{"name", "id", "if", "run", "uses", "with", "env",
                                           "continue-on-error"}),
                    Contains(key.first.Scalar()));
      }
    }
  }
  for (const char* action : {"actions/cache/save@", "actions/cache/restore@",
                             "actions/upload-artifact@", "upload-sarif@"}) {
    EXPECT_THAT(uses, HasSubstr(action));
  }
}

TEST(CiExample, GitlabPipelineHasJobsOfKnownStagesAndNeeds) {
  const YAML::Node pipeline = YAML::LoadFile(kFolder + "/gitlab.yml");
  std::set<std::string> stages;
  for (const YAML::Node& stage : pipeline["stages"]) stages.insert(stage.Scalar());
  const std::set<std::string> no_jobs = {"stages", "default", "variables"};
  std::size_t jobs = 0;
  for (const auto& entry : pipeline) {
    const std::string name = entry.first.Scalar();
    const YAML::Node& job = entry.second;
    if (no_jobs.contains(name) || name.starts_with(".")) continue;
    ++jobs;
    EXPECT_THAT(stages, Contains(job["stage"].Scalar())) << name;
    EXPECT_TRUE(job["script"].IsSequence()) << name;
    for (const YAML::Node& line : job["script"]) EXPECT_TRUE(line.IsScalar()) << name;
    EXPECT_TRUE(pipeline[job["extends"].Scalar()].IsDefined()) << name;
    for (const YAML::Node& need : job["needs"]) {
      EXPECT_TRUE(pipeline[need.Scalar()].IsDefined()) << name;
    }
  }
  EXPECT_EQ(jobs, 3U);
  EXPECT_EQ(pipeline["gate"]["artifacts"]["reports"]["junit"].Scalar(), "map/gate.junit.xml");
  EXPECT_TRUE(pipeline[".map"]["cache"]["paths"].IsSequence());
}

// docs.github.com, "Metadata syntax": inputs and outputs are described, each shell step names its
// shell, and expressions name inputs and steps that are there.
TEST(CiExample, CompositeActionHasTheShapeThatGithubAsksFor) {
  const YAML::Node action = YAML::LoadFile(kFolder + "/action.yml");
  for (const char* key : {"name", "description"}) EXPECT_TRUE(action[key].IsScalar()) << key;
  EXPECT_EQ(action["runs"]["using"].Scalar(), "composite");
  std::set<std::string> inputs;
  for (const auto& input : action["inputs"]) {
    inputs.insert(input.first.Scalar());
    EXPECT_TRUE(input.second["description"].IsScalar()) << input.first;
    EXPECT_TRUE(input.second["default"].IsDefined()) << input.first;
  }
  std::set<std::string> ids;
  for (const YAML::Node& step : action["runs"]["steps"]) {
    EXPECT_NE(step["run"].IsDefined(), step["uses"].IsDefined());
    EXPECT_EQ(step["run"].IsDefined(), step["shell"].IsDefined());
    if (step["id"]) {
      EXPECT_TRUE(ids.insert(step["id"].Scalar()).second);
    }
  }
  for (const auto& output : action["outputs"]) EXPECT_TRUE(output.second["value"].IsScalar());
  const std::string text = text_of("action.yml");
  EXPECT_LT(text.find("actions/cache/restore@"), text.find("run\" compile"));
  const std::regex named("(inputs|steps)\\.([a-z0-9_]+)");
  for (std::sregex_iterator at(text.begin(), text.end(), named), end; at != end; ++at) {
    EXPECT_THAT((*at)[1] == "inputs" ? inputs : ids, Contains((*at)[2].str()));
  }
}

// docs.gitlab.com, "CI/CD components": a header `spec` with inputs, then the pipeline.
TEST(CiExample, GitlabComponentDescribesItsInputsAndUsesThemAlone) {
  const std::vector<YAML::Node> documents =
      YAML::LoadAllFromFile(kFolder + "/gitlab-component.yml");
  ASSERT_EQ(documents.size(), 2U);
  std::set<std::string> inputs;
  for (const auto& input : documents[0]["spec"]["inputs"]) {
    inputs.insert(input.first.Scalar());
    EXPECT_TRUE(input.second["description"].IsScalar()) << input.first;
  }
  EXPECT_EQ(matches_in("gitlab-component.yml", "\\$\\[\\[ inputs\\.([a-z0-9_]+) \\]\\]"), inputs);
  ASSERT_EQ(documents[1].size(), 1U);
  const YAML::Node job = documents[1].begin()->second;
  EXPECT_TRUE(job["script"].IsSequence());
  EXPECT_EQ(job["cache"]["when"].Scalar(), "always");
}

}  // namespace
