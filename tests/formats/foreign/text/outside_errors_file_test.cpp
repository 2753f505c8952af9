#include "formats/foreign/text/outside_errors_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Result<std::vector<OutsideError>> read(const std::string& text) {
  const std::filesystem::path file = scratch_folder() / "errors.csv";
  EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace));
  return read_outside_errors(file);
}

TEST(OutsideErrorsFile, ReadsErrorsInTheOrderOfScansWhateverTheOrderOfLinesAndColumns) {
  const std::vector<OutsideError> errors = value_of(
      read("\xef\xbb\xbf# by the new matcher\r\n\r\nstart, error_m ,scan,look_m\r\n1,0.25,7,20\r\n"
           "0,+1e-2,7,20\r\n# half way\n0,0,3,10"));
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_EQ(errors[0].scan, 3u);
  EXPECT_EQ(errors[0].range_m, 10.0);
  EXPECT_EQ(errors[0].error_m, 0.0);
  EXPECT_EQ(errors[0].line, 7u);
  EXPECT_EQ(errors[1].error_m, 0.01);
  EXPECT_EQ(errors[2].start, 1u);
  EXPECT_EQ(errors[2].line, 4u);
  EXPECT_TRUE(read("scan,range,start,error\n0,10,0,0.1\n"));
}

TEST(OutsideErrorsFile, NamesFileAndLineOfWhatItRefuses) {
  const struct {
    const char* text;
    ErrorCode code;
    const char* place;
    const char* message;
  } kCases[] = {
      {"", ErrorCode::kMalformedText, "line 0", "found no error"},
      {"scan,look,start,error\n", ErrorCode::kMalformedText, "line 1", "found no error"},
      {"scan,look,start\n0,10,0\n", ErrorCode::kMissingField, "line 1", "no column error"},
      {"0,10,0,0.1\n", ErrorCode::kMalformedText, "line 1", "found a column '0'"},
      {"scan,look,start,error,time\n", ErrorCode::kMalformedText, "line 1", "'time'"},
      {"scan,look,range,start,error\n", ErrorCode::kMalformedText, "line 1", "look twice"},
      {"scan,look,start,error\n0,10,0\n", ErrorCode::kMalformedText, "line 2", "found 3 columns"},
      {"scan,look,start,error\n\n0,10,,0.1\n", ErrorCode::kMalformedText, "line 3", "start ''"},
      {"scan,look,start,error\n-1,10,0,0.1\n", ErrorCode::kMalformedText, "line 2", "scan '-1'"},
      {"scan,look,start,error\n1.5,10,0,0.1\n", ErrorCode::kMalformedText, "line 2", "'1.5'"},
      {"scan,look,start,error\n1,0,0,0.1\n", ErrorCode::kMalformedText, "line 2", "look '0'"},
      {"scan,look,start,error\n1,10,0,nan\n", ErrorCode::kMalformedText, "line 2", "error 'nan'"},
      {"scan,look,start,error\n1,10,0,-0.1\n", ErrorCode::kMalformedText, "line 2", "'-0.1'"},
      {"scan,look,start,error\n1,10,0,0.1m\n", ErrorCode::kMalformedText, "line 2", "'0.1m'"},
      {"scan,look,start,error\n4,10,2,0.1\n4,20,2,0.1\n4,10,2,0.3\n", ErrorCode::kMalformedText,
       "line 4", "look 10 m, start 2 again, as in line 2"}};
  for (const auto& each : kCases) {
    const Error error = failure_of(read(each.text), each.text);
    EXPECT_EQ(error.code, each.code) << to_string(error);
    EXPECT_EQ(error.place, each.place) << each.text;
    EXPECT_THAT(error.message, testing::HasSubstr(each.message)) << to_string(error);
    EXPECT_TRUE(error.file.ends_with("errors.csv"));
  }
  EXPECT_EQ(read_outside_errors("/nowhere.csv").error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace sightline
