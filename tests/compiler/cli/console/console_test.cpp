#include "compiler/cli/console/console.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace sightline
