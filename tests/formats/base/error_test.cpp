#include "formats/base/error.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>

#include "formats/base/result.h"

namespace sightline {
namespace {

// "| SL2001 | file-not-found | ..." -> {2001, "file-not-found"}
std::map<int, std::string> documented_codes() {
  std::map<int, std::string> codes;
  std::ifstream file(SIGHTLINE_ERROR_CODES);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("| SL")) continue;
    const std::size_t begin = line.find("| ", 4) + 2;
    codes[std::stoi(line.substr(4, 4))] = line.substr(begin, line.find(" |", begin) - begin);
  }
  return codes;
}

TEST(ErrorCodes, AreTheSameInTheCodeAndInTheDocumentation) {
  std::map<int, std::string> in_code;
  for (const ErrorCodeInfo& info : all_error_codes()) {
    in_code[static_cast<int>(info.code)] = info.name;
  }
  EXPECT_EQ(in_code, documented_codes());
  EXPECT_EQ(in_code.size(), all_error_codes().size()) << "a number stands twice";
}

TEST(ErrorCodes, EndTheProgramWithAStatusThatShellsAndTimeoutsDoNotUse) {
  for (const ErrorCodeInfo& info : all_error_codes()) {
    const int status = exit_status(info.code);
    EXPECT_GE(status, 64) << info.name;
    EXPECT_LE(status, 78) << info.name;
  }
}

TEST(Error, SaysCodeFilePlaceAndReason) {
  const Error error{ErrorCode::kTruncatedScan, "found 10 bytes, expected 16", "a.pcd", "byte 128"};
  EXPECT_EQ(to_string(error),
            "SL2006 truncated-scan: a.pcd (byte 128): found 10 bytes, expected 16");
  EXPECT_EQ(to_string(Error{ErrorCode::kNoPoses, "none", "", "pass ingest"}),
            "SL2015 no-poses: (pass ingest): none");
  EXPECT_EQ(to_string(Error{ErrorCode::kNoPoses, "none"}), "SL2015 no-poses: none");
}

TEST(ResultDeathTest, StopsWhoeverLooksAtTheWrongOne) {
  const Result<int> good = 3;
  const Result<int> bad = Error{ErrorCode::kNoPoses, "none"};
  EXPECT_EQ(good.value(), 3);
  EXPECT_EQ(bad.error().code, ErrorCode::kNoPoses);
  EXPECT_DEATH((void)good.error(), "internal error");
  EXPECT_DEATH((void)bad.value(), "internal error");
}

}  // namespace
}  // namespace sightline
