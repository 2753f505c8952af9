#include "compiler/cli/console/console.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "compiler/pipeline/runner.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

StepReport row(const std::string& name, bool from_cache, const std::string& reason) {
  StepReport report;
  report.name = name;
  report.from_cache = from_cache;
  report.reason = reason;
  return report;
}

std::string line_of(const std::string& text, const std::string& name) {
  const std::size_t begin = text.find(name);
  return text.substr(begin, text.find('\n', begin) - begin);
}

TEST(TimeTable, SaysWhereAnOutputComesFromUnlessItWasMade) {
  const std::string text =
      time_table({row("ingest", true, std::string(kNotNeeded)), row("build-ndt", true, "unchanged"),
                  row("emit-map", false, "its inputs changed")});
  EXPECT_THAT(line_of(text, "ingest"), HasSubstr("(not needed)"));
  EXPECT_THAT(line_of(text, "build-ndt"), HasSubstr("(from the cache)"));
  EXPECT_THAT(line_of(text, "emit-map"), Not(HasSubstr("(")));
}

StepReport taken(double wall_s, bool from_cache = false) {
  StepReport report;
  report.wall_s = wall_s;
  report.from_cache = from_cache;
  return report;
}

std::vector<ExpectedTime> expected_s(const std::vector<double>& each_s) {
  std::vector<ExpectedTime> expected;
  for (const double of_step_s : each_s) expected.push_back({of_step_s, 1.0});
  return expected;
}

TEST(RemainingTime, IsThatOfTheStepAndWhatIsExpectedOfLaterOnes) {
  RemainingTime time(expected_s({10.0, 20.0, 30.0}));
  time.start(0);
  EXPECT_EQ(time.of_run_s(4.0), 54.0);
  time.start(2);
  EXPECT_EQ(time.of_run_s(4.0), 4.0);
}

TEST(RemainingTime, IsCorrectedByWhatStepsTookThatRan) {
  RemainingTime time(expected_s({10.0, 0.0, 30.0, 8.0}));
  time.start(0);
  time.finish(taken(20.0));
  time.start(1);
  time.finish(taken(0.1, true));  // says nothing of this machine
  time.start(2);
  // Twice the expected 10 s, beside a twentieth of the 48 s of trust in what was expected.
  EXPECT_NEAR(time.of_run_s(60.0).value(), 60.0 + 22.4 / 12.4 * 8.0, 1e-9);
}

TEST(RemainingTime, IsCorrectedByThePresentStepAlready) {
  RemainingTime time(expected_s({100.0, 100.0}));
  time.start(0);
  // A quarter is done in 75 s: three times as slow as expected.
  EXPECT_NEAR(time.of_run_s(225.0, 75.0).value(), 225.0 + 100.0 * 85.0 / 35.0, 1e-9);
}

TEST(RemainingTime, OfAStepIsAsExpectedAtFirstAndAsCountedAtLast) {
  RemainingTime time(expected_s({0.0, 20.0, 10.0}));
  time.start(1);
  EXPECT_NEAR(time.of_step_s(0.2, 10, 100), 18.2 - 0.2, 1e-9) << "a tenth of 2 s, the rest of 20 s";
  EXPECT_NEAR(time.of_step_s(9.0, 90, 100), 11.0 - 9.0, 1e-9) << "of 10 s and of 20 s";
  EXPECT_NEAR(time.of_step_s(30.0, 50, 100), 30.0, 1e-9) << "20 s are over";
  EXPECT_EQ(time.of_step_s(40.0, 100, 100), 0.0);
  time.start(3);
  EXPECT_EQ(time.of_step_s(1.0, 50, 100), 1.0) << "nothing is expected";
}

// The odometry of a step is counted, what follows is not.
TEST(RemainingTime, OfAStepThatCountsAPartOfItsWorkHasTheRest) {
  RemainingTime time({{20.0, 0.25}});
  time.start(0);
  EXPECT_NEAR(time.of_step_s(5.0, 100, 100), 15.0, 1e-9);
  EXPECT_NEAR(time.of_step_s(8.0, 100, 100), 12.0, 1e-9) << "without another report";
  EXPECT_NEAR(time.of_step_s(30.0, 100, 100), 0.0, 1e-9);
  time.start(0);
  EXPECT_NEAR(time.of_step_s(10.0, 100, 100), 30.0, 1e-9) << "twice as slow";
}

TEST(RemainingTime, OfARunOfWhichNothingIsExpectedIsNotTold) {
  RemainingTime time({});
  time.start(0);
  EXPECT_FALSE(time.of_run_s(4.0));
}

TEST(RemainingTime, IsShownInMinutesAndHours) {
  EXPECT_EQ(seconds_left(3.0, 1, 4), 9.0);
  EXPECT_EQ(clock_text(65.2), "1:05");
  EXPECT_EQ(clock_text(7380.0), "2:03:00");
}

TEST(Toned, LeavesTextAsItIsWhereStdoutIsNoTerminal) {
  EXPECT_EQ(toned(Tone::kGood, "good"), "good");
  ::testing::internal::CaptureStdout();
  print_text(toned(Tone::kBad, "bad") + " \033[31mred\033[0m\n");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "bad \\x1b[31mred\\x1b[0m\n");
}

// stderr is no terminal here.
TEST(ConsoleObserver, PrintsTheProgressOfALongPassInALogNowAndThen) {
  const auto logged = [](double line_every_s, Verbosity verbosity) {
    ::testing::internal::CaptureStderr();
    const RunObserver observer = console_observer(verbosity, {}, line_every_s);
    observer.started(0, 2, "build-ndt");
    for (std::size_t i = 1; i <= 4; ++i) observer.progress(i, 4);
    return ::testing::internal::GetCapturedStderr();
  };
  const std::string text = logged(0.0, Verbosity::kNormal);
  EXPECT_THAT(text, HasSubstr("info [1/2] build-ndt  2/4  0:00 left\n"));
  EXPECT_THAT(text, Not(HasSubstr("\033")));
  EXPECT_EQ(logged(0.0, Verbosity::kQuiet), "");
  EXPECT_EQ(logged(30.0, Verbosity::kNormal), "");
}

TEST(ConsoleObserver, PrintsInALogThatAPassIsStillAtWorkThatReportsNothing) {
  const auto logged = [](std::size_t done) {
    ::testing::internal::CaptureStderr();
    const RunObserver observer = console_observer(Verbosity::kNormal, {}, 0.2);
    observer.started(0, 2, "build-ndt");
    if (done > 0) observer.progress(done, 4);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(logged(0), HasSubstr("info [1/2] build-ndt  0:00 so far\n"));
  EXPECT_THAT(logged(2), HasSubstr("info [1/2] build-ndt  2/4  0:00 left\n"));
}

TEST(ReportError, PrintsAPathOnOneLineAndNoCommandOfALog) {
  ::testing::internal::CaptureStderr();
  report_error({ErrorCode::kCannotOpen, "no\n::error::b", "a\n::error::c"});
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("a\\x0a::error::c: no\n\\x3a:error::b\n"));
}

TEST(Verbosity, SilencesNotesAndNoWarnings) {
  ::testing::internal::CaptureStderr();
  set_verbosity(Verbosity::kQuiet);
  print_note("a note");
  print_warning("a warning");
  set_verbosity(Verbosity::kNormal);
  print_note("another note");
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(text.find("a note"), std::string::npos);
  EXPECT_NE(text.find("warning a warning"), std::string::npos) << text;
  EXPECT_NE(text.find("another note\n"), std::string::npos);
}

}  // namespace
}  // namespace sightline
