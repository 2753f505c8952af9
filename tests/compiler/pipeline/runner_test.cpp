#include "compiler/pipeline/runner.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {

struct Number {
  std::int64_t value = 0;
};
template <>
struct ArtifactTraits<Number> {
  static constexpr std::string_view kName = "number";
  static constexpr std::uint32_t kVersion = 1;
};
Result<void> validate(const Number& number) {
  if (number.value < 1000) return {};
  return Error{ErrorCode::kInvalidArtifact, "a number must stay below 1000"};
}
Table dump(const Number& number) { return {"number", {"value"}, {{number.value}}, {}}; }
void encode(const Number& number, ByteWriter& writer) { writer.put(number.value); }
void decode(ByteReader& reader, Number& number) { reader.get(number.value); }

// One whose content lies outside: no step that makes it gives it back, so it is never loaded.
struct Handle {
  std::int64_t value = 0;
};
template <>
struct ArtifactTraits<Handle> {
  static constexpr std::string_view kName = "handle";
  static constexpr std::uint32_t kVersion = 1;
  static constexpr bool kRefersOutside = true;
};
Result<void> validate(const Handle& /*handle*/) { return {}; }
Table dump(const Handle& handle) { return {"handle", {"value"}, {{handle.value}}, {}}; }
void encode(const Handle& handle, ByteWriter& writer) { writer.put(handle.value); }
void decode(ByteReader& reader, Handle& handle) { reader.get(handle.value); }

struct ScaleOptions {
  int factor = 2;
};
std::vector<OptionField> option_fields(ScaleOptions& options) {
  return {integer("factor", options.factor, "what to multiply by", -1000, 1000)};
}

namespace {

int g_calls = 0;  // how often a pass really ran

Result<Number> scale(PassContext& ctx, const ScaleOptions& options, const Number& a) {
  ++g_calls;
  ctx.warn("scaled once");
  ctx.warn("scaled once");  // the same again is not repeated
  if (options.factor == 0) return Error{ErrorCode::kNoOverlap, "nothing left"};
  return Number{a.value * options.factor};
}

Result<Number> add(PassContext& /*ctx*/, const ScaleOptions& /*options*/, const Number& a,
                   const Number& b) {
  ++g_calls;
  return Number{a.value + b.value};
}

constexpr Pass kScale{"scale", 1, "scaled", "A number times another", &scale};
constexpr Pass kAdd{"add", 1, "sum", "The sum of two numbers", &add};

Result<Handle> open_handle(PassContext& ctx, const NoOptions& /*options*/, const Number& a) {
  ++g_calls;
  ctx.warn("half of it is left out");
  return Handle{a.value};
}

Result<Number> read_handle(PassContext& /*ctx*/, const NoOptions& /*options*/,
                           const Handle& handle) {
  ++g_calls;
  return Number{handle.value};
}

constexpr Pass kOpen{"open", 1, "handle", "A number that lies outside", &open_handle};
constexpr Pass kRead{"read", 1, "read", "The number of a handle", &read_handle};

class Runner : public TestInFolder {
 protected:
  Runner() {
    options_.cache_directory = folder_;
    options_.threads = 1;
    g_calls = 0;
  }

  // source -> scale -> scaled; source, scaled -> add -> sum
  enum class Wants { kAll, kScaled, kSum };
  Result<void> run(int factor, std::int64_t source = 3, Wants wants = Wants::kAll) {
    Plan plan;
    const Wire<Number> source_wire = plan.input<Number>("source");
    scaled_ = plan.run_as("", kScale, ScaleOptions{factor}, source_wire);
    sum_ = plan.run(kAdd, source_wire, scaled_);
    artifacts_ = {};
    artifacts_.provide(source_wire, Number{source}, sha256(std::to_string(source)));
    reports_.clear();
    std::vector<AnyWire> wanted;
    if (wants == Wants::kScaled) wanted = {scaled_};
    if (wants == Wants::kSum) wanted = {sum_};
    return run_plan(plan, wanted, options_, observer_, artifacts_, reports_);
  }

  [[nodiscard]] std::vector<std::filesystem::path> objects_of(const std::string& pass) const {
    std::vector<std::filesystem::path> objects;
    for (const auto& entry : std::filesystem::directory_iterator(options_.cache_directory)) {
      const std::filesystem::path& path = entry.path();
      if (path.extension() == ".sla" && path.filename().string().starts_with(pass + "-")) {
        objects.push_back(path);
      }
    }
    return objects;
  }

  Wire<Number> scaled_;
  Wire<Number> sum_;
  RunOptions options_;
  RunObserver observer_;
  ArtifactSet artifacts_;
  std::vector<StepReport> reports_;
};

TEST_F(Runner, RunsEachStepOnItsInputs) {
  ASSERT_TRUE(run(2));
  EXPECT_EQ(artifacts_.get(scaled_).value, 6);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
  EXPECT_EQ(reports_.at(0).reason, "never ran here");
  EXPECT_EQ(reports_.at(0).warnings, std::vector<std::string>{"scaled once"});
  EXPECT_GT(reports_.at(0).peak_memory_mib, 0.0);
}

TEST_F(Runner, DoesNothingTwice) {
  ASSERT_TRUE(run(2));
  ASSERT_TRUE(run(2));
  EXPECT_EQ(g_calls, 2);
  EXPECT_TRUE(reports_.at(1).from_cache);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
}

// As where a drive is named at another place of a configuration.
TEST_F(Runner, DoesNotRunAgainUnderAnotherLabel) {
  for (const char* label : {"mapping", "mapping[2]"}) {
    Plan plan;
    const Wire<Number> source = plan.input<Number>(std::string(label) + "/source");
    const Wire<Number> scaled = plan.run_as(label, kScale, ScaleOptions{4}, source);
    ArtifactSet artifacts;
    artifacts.provide(source, Number{3});
    ASSERT_TRUE(run_plan(plan, {scaled}, options_, observer_, artifacts, reports_));
    EXPECT_EQ(artifacts.get(scaled).value, 12);
    EXPECT_EQ(g_calls, 1);
    EXPECT_EQ(reports_.back().warnings, std::vector<std::string>{"scaled once"});
  }
}

TEST_F(Runner, RunsAgainWhatAChangeReachesAndSaysWhy) {
  ASSERT_TRUE(run(2));
  ASSERT_TRUE(run(5));
  EXPECT_EQ(g_calls, 4);
  EXPECT_EQ(reports_.at(0).reason, "option factor was 2, is 5");
  EXPECT_EQ(reports_.at(1).reason, "input scaled changed");
  ASSERT_TRUE(run(5, 4));
  EXPECT_EQ(reports_.at(0).reason, "input source changed");
  EXPECT_EQ(artifacts_.get(sum_).value, 24);
}

TEST_F(Runner, GoesOnFromWhereAFailedRunStopped) {
  ASSERT_TRUE(run(2));
  const Error failed = failure_of(run(0));
  EXPECT_EQ(failed.code, ErrorCode::kNoOverlap);
  EXPECT_EQ(failed.place, "pass scale");
  ASSERT_TRUE(run(2));
  EXPECT_EQ(g_calls, 3) << "the first run's results are still there";
}

TEST_F(Runner, NamesThePassWhoseOutputIsInvalidAndKeepsNothingOfIt) {
  const Error failed = failure_of(run(500));
  EXPECT_EQ(failed.code, ErrorCode::kInvalidArtifact);
  EXPECT_EQ(failed.place, "pass scale");
  EXPECT_FALSE(artifacts_.has(scaled_));
  ASSERT_FALSE(run(500));
  EXPECT_EQ(g_calls, 2);
}

TEST_F(Runner, MakesADamagedCacheFileAnewAndSaysSo) {
  ASSERT_TRUE(run(2));
  for (const auto& entry : std::filesystem::directory_iterator(options_.cache_directory)) {
    if (entry.path().extension() != ".sla") continue;
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(30);
    file.put('\x7f');
  }
  ASSERT_TRUE(run(2));
  EXPECT_EQ(g_calls, 4);
  ASSERT_FALSE(reports_.at(0).warnings.empty());
  EXPECT_NE(reports_.at(0).warnings.at(0).find("digest-mismatch"), std::string::npos);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
}

TEST_F(Runner, MakesAnewWhatLiesInThePlaceOfAnother) {
  ASSERT_TRUE(run(2));
  const std::filesystem::path of_two = objects_of("scale").at(0);
  ASSERT_TRUE(run(5));
  ASSERT_EQ(objects_of("scale").size(), 2U);
  for (const std::filesystem::path& object : objects_of("scale")) {
    if (object == of_two) continue;
    std::filesystem::copy_file(of_two, object, std::filesystem::copy_options::overwrite_existing);
  }
  ASSERT_TRUE(run(5));
  EXPECT_EQ(artifacts_.get(sum_).value, 18);
  ASSERT_FALSE(reports_.at(0).warnings.empty());
  EXPECT_NE(reports_.at(0).warnings.at(0).find("SL4008"), std::string::npos)
      << reports_.at(0).warnings.at(0);
}

TEST_F(Runner, LeavesForeignFilesInTheCacheAlone) {
  ASSERT_TRUE(run(2));
  const std::filesystem::path mine = options_.cache_directory / "mine.tmp";
  ASSERT_TRUE(write_file_atomically(mine, std::string_view("precious"), IfExists::kRefuse));
  ASSERT_TRUE(run(3));
  EXPECT_EQ(*read_text_file(mine), "precious");
}

// A file in the place of the cache's folder stands for one that cannot be written.
TEST_F(Runner, GoesOnWithoutACacheThatCannotBeWrittenAndSaysSoOnce) {
  std::ofstream(folder_ / "file") << "x";
  options_.cache_directory = folder_ / "file" / "cache";
  std::vector<std::string> warnings;
  observer_.warning = [&](const std::string& /*pass*/, const std::string& message) {
    if (message.find("cannot be written") != std::string::npos) warnings.push_back(message);
  };
  ASSERT_TRUE(run(2));
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("--no-cache"), std::string::npos) << warnings[0];
  options_.must_store = true;
  EXPECT_EQ(code_of(run(2)), ErrorCode::kCannotWrite);
}

// Only when the first object is stored it turns out that this cannot be done.
TEST_F(Runner, GoesOnWhereStoringFailsMeanwhile) {
  std::vector<std::string> warnings;
  observer_.started = [&](std::size_t, std::size_t, const std::string&) {
    std::filesystem::remove_all(folder_);
    std::ofstream(folder_) << "x";  // no folder any more
  };
  observer_.warning = [&](const std::string& /*pass*/, const std::string& message) {
    if (message.find("cannot be written") != std::string::npos) warnings.push_back(message);
  };
  ASSERT_TRUE(run(2));
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
  EXPECT_EQ(warnings.size(), 1U);
  std::filesystem::remove(folder_);
  std::filesystem::create_directories(folder_);
  options_.must_store = true;
  EXPECT_EQ(code_of(run(3)), ErrorCode::kCannotWrite);
  std::filesystem::remove(folder_);
}

TEST_F(Runner, StopsAndPrintsWhereItIsAsked) {
  std::vector<std::string> printed;
  observer_.printed = [&](const std::string& pass, const Table& table) {
    printed.push_back(pass + ":" + format_table(table, TableFormat::kCsv));
  };
  options_.print_after = {"scale"};
  options_.stop_after = "scale";
  ASSERT_TRUE(run(2));
  EXPECT_EQ(printed, std::vector<std::string>{"scale:value\n6\n"});
  EXPECT_FALSE(artifacts_.has(sum_));
}

TEST_F(Runner, RunsOnlyWhatTheWantedArtifactNeeds) {
  ASSERT_TRUE(run(2, 3, Wants::kScaled));
  EXPECT_TRUE(artifacts_.has(scaled_));
  EXPECT_FALSE(artifacts_.has(sum_));
  EXPECT_EQ(g_calls, 1);
}

TEST_F(Runner, LoadsNothingThatIsNotNeeded) {
  ASSERT_TRUE(run(2));
  for (const std::filesystem::path& object : objects_of("scale")) std::filesystem::remove(object);
  ASSERT_TRUE(run(2, 3, Wants::kSum));
  EXPECT_EQ(g_calls, 2) << "the sum is there, so what it was made of is not needed";
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
  ASSERT_EQ(reports_.size(), 2U);
  EXPECT_TRUE(reports_[0].from_cache);
  EXPECT_EQ(reports_[0].reason, "not needed");
}

TEST_F(Runner, MakesWhatADamagedObjectWasMadeOf) {
  ASSERT_TRUE(run(2));
  for (const std::filesystem::path& object : objects_of("scale")) std::filesystem::remove(object);
  for (const std::filesystem::path& object : objects_of("add")) {
    std::filesystem::resize_file(object, std::filesystem::file_size(object) - 1);
  }
  ASSERT_TRUE(run(2, 3, Wants::kSum));
  EXPECT_EQ(g_calls, 4);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
}

TEST_F(Runner, LetsGoWhatNobodyWants) {
  for (const bool has_cache : {true, false}) {
    if (!has_cache) options_.cache_directory.clear();
    ASSERT_TRUE(run(2, 3, Wants::kSum));
    EXPECT_TRUE(artifacts_.has(sum_));
    EXPECT_FALSE(artifacts_.has(scaled_));
  }
}

TEST_F(Runner, LetsGoWhatIsWantedTooWhereItIsOnlyToBeStored) {
  options_.keeps_wanted = false;
  for (const int calls : {2, 2}) {
    ASSERT_TRUE(run(2));
    EXPECT_EQ(g_calls, calls);
    EXPECT_FALSE(artifacts_.has(sum_));
    EXPECT_FALSE(artifacts_.has(scaled_));
  }
  options_.keeps_wanted = true;
  ASSERT_TRUE(run(2));
  EXPECT_EQ(g_calls, 2);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
}

TEST_F(Runner, LoadsWhatAStepTakesWhenItIsTaken) {
  ASSERT_TRUE(run(2));
  for (const std::filesystem::path& object : objects_of("add")) std::filesystem::remove(object);
  std::vector<std::string> loaded_too_early;
  observer_.finished = [&](const StepReport& report) {
    if (artifacts_.has(scaled_)) loaded_too_early.push_back(report.name);
  };
  ASSERT_TRUE(run(2, 3, Wants::kSum));
  EXPECT_EQ(g_calls, 3);
  EXPECT_EQ(artifacts_.get(sum_).value, 9);
  EXPECT_EQ(loaded_too_early, std::vector<std::string>{});
}

TEST_F(Runner, RepeatsTheWarningsOfWhatItFindsInTheCache) {
  ASSERT_TRUE(run(2));
  for (const Wants wants : {Wants::kAll, Wants::kSum}) {
    std::vector<std::string> messages;
    observer_.warning = [&](const std::string& pass, const std::string& message) {
      messages.push_back(pass + ": " + message);
    };
    ASSERT_TRUE(run(2, 3, wants));
    EXPECT_EQ(g_calls, 2);
    EXPECT_EQ(messages, std::vector<std::string>{"scale: scaled once"});
    EXPECT_EQ(reports_.at(0).warnings, std::vector<std::string>{"scaled once"});
  }
}

// A warning about a drive is repeated each time, though the drive is not opened again.
TEST_F(Runner, RepeatsTheWarningsOfWhatIsNeverKeptAndNotNeeded) {
  for (int run = 0; run < 2; ++run) {
    Plan plan;
    const Wire<Number> source = plan.input<Number>("source");
    const Wire<Number> read = plan.run(kRead, plan.run(kOpen, source));
    ArtifactSet artifacts;
    artifacts.provide(source, Number{3});
    std::vector<std::string> messages;
    observer_.warning = [&](const std::string& pass, const std::string& message) {
      messages.push_back(pass + ": " + message);
    };
    ASSERT_TRUE(run_plan(plan, {read}, options_, observer_, artifacts, reports_));
    EXPECT_EQ(artifacts.get(read).value, 3);
    EXPECT_EQ(g_calls, 2) << "the second run finds what was read";
    EXPECT_EQ(messages, std::vector<std::string>{"open: half of it is left out"});
  }
}

TEST_F(Runner, NamesWhatIsMissingOfWhatMayNotRun) {
  options_.may_run = [](const std::string& step) { return step == "add"; };
  const Error refused = failure_of(run(2, 3, Wants::kSum));
  EXPECT_EQ(refused.code, ErrorCode::kWorkMissing);
  EXPECT_EQ(refused.message, "not finished yet: scale");
  EXPECT_EQ(g_calls, 0);
  options_.may_run = nullptr;
  ASSERT_TRUE(run(2, 3, Wants::kScaled));
  options_.may_run = [](const std::string& step) { return step == "add"; };
  ASSERT_TRUE(run(2, 3, Wants::kSum));
  EXPECT_EQ(g_calls, 2);
}

TEST_F(Runner, RefusesThePassThatDoesNotExistBeforeAnythingRuns) {
  options_.stop_after = "scael";
  const Error refused = failure_of(run(2));
  EXPECT_EQ(refused.code, ErrorCode::kUnknownPass);
  EXPECT_NE(refused.message.find("did you mean scale?"), std::string::npos);
  EXPECT_EQ(g_calls, 0);
}

}  // namespace
}  // namespace sightline
