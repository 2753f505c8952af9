#include "compiler/cli/file_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "compiler/cli/command_line.h"
#include "compiler/commands/commands.h"
#include "formats/model/error_model.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class FileKinds : public TestInFolder {
 protected:
  std::string write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }
  std::string map() { return write("a.slmap", std::string("\x89SLM\r\n\x1a\n\0\0\0\0", 12)); }
  std::string configuration() { return write("a.yaml", "mapping: {scans: drive}\n"); }

  static std::string complaint(const std::vector<std::string>& words, int expected_status) {
    ::testing::internal::CaptureStderr();
    const int status = run_command_line(sightline_program(), words);
    EXPECT_EQ(status, expected_status) << ::testing::PrintToString(words);
    return ::testing::internal::GetCapturedStderr();
  }
};

TEST_F(FileKinds, AreToldByFirstBytesAndEndings) {
  EXPECT_EQ(kind_of_file(folder_), FileKind::kFolder);
  EXPECT_EQ(kind_of_file(map()), FileKind::kMap);
  const std::vector<std::byte> model = to_bytes(ErrorModel{});
  EXPECT_EQ(
      kind_of_file(write("a.slmodel", {reinterpret_cast<const char*>(model.data()), model.size()})),
      FileKind::kModel);
  EXPECT_EQ(kind_of_file(write("a", std::string("\x89SLD\r\n\x1a\n", 8))), FileKind::kDelta);
  EXPECT_EQ(kind_of_file(configuration()), FileKind::kConfiguration);
  EXPECT_EQ(kind_of_file(write("0.pcd", "VERSION 0.7\n")), FileKind::kRecording);
  EXPECT_EQ(kind_of_file(write("poses.txt", "1 2 3\n")), std::nullopt);
  EXPECT_EQ(kind_of_file(write("b.yaml", std::string("\0\0", 2))), std::nullopt);
  EXPECT_EQ(kind_of_file(folder_ / "nothing"), std::nullopt);
}

TEST_F(FileKinds, AFolderWhereAFileIsWantedIsSentToInit) {
  EXPECT_THAT(complaint({"compile", folder_.string()}, 74),
              AllOf(HasSubstr("SL8002"), HasSubstr("this is a folder"),
                    HasSubstr("sightline init " + folder_.string())));
  EXPECT_THAT(complaint({"inspect", folder_.string()}, 74), HasSubstr("sightline init"));
}

TEST_F(FileKinds, AMapWhereAConfigurationIsWantedIsNamed) {
  EXPECT_THAT(complaint({"compile", map()}, 65),
              AllOf(HasSubstr("this is a compiled map"), HasSubstr("sightline inspect"),
                    Not(HasSubstr("not YAML"))));
  EXPECT_THAT(complaint({"train", map(), "-o", (folder_ / "b.slmodel").string()}, 65),
              HasSubstr("this is a compiled map"));
}

TEST_F(FileKinds, AConfigurationWhereAMapIsWantedIsNamed) {
  for (const char* verb : {"inspect", "verify", "gate"}) {
    EXPECT_THAT(complaint({verb, configuration()}, 67),
                AllOf(HasSubstr("SL4001"), HasSubstr("this is a configuration"),
                      HasSubstr("sightline compile " + configuration())))
        << verb;
  }
  EXPECT_THAT(complaint({"init", configuration()}, 74), HasSubstr("this is a configuration"));
}

TEST_F(FileKinds, AReportOfAConfigurationAsksForItsMap) {
  const std::string page = (folder_ / "page.html").string();
  EXPECT_THAT(complaint({"report", configuration(), "-o", page}, 64),
              AllOf(HasSubstr("SL1001"), HasSubstr("add --map FILE")));
  EXPECT_THAT(complaint({"report", map(), "-o", page, "--set", "a.b=1"}, 64),
              HasSubstr("--set: a map alone has no configuration"));
}

TEST_F(FileKinds, AScanWhereAConfigurationIsWantedIsNamed) {
  const std::string scan = write("0.pcd", "DATA binary\n: \x01\x02\t{");
  EXPECT_THAT(complaint({"compile", scan}, 65),
              AllOf(HasSubstr("one scan of a recording"),
                    HasSubstr("`sightline init " + folder_.string() + " -o drive.yaml`")));
}

TEST_F(FileKinds, ARecordingWhereAConfigurationIsWantedIsNamedWithTheNextStep) {
  for (const char* name : {"drive.bag", "drive.db3", "drive.mcap", "drive.pcap", "drive.pcapng"}) {
    const std::string recording = write(name, std::string("#\x01\x02: {\0", 7));
    EXPECT_THAT(complaint({"compile", recording, "-o", "drive.slmap"}, 65),
                HasSubstr("this is a recording: `sightline init " + recording + " -o drive.yaml`"))
        << name;
  }
}

TEST_F(FileKinds, WhatIsOfTheWantedKindKeepsItsOwnMessage) {
  EXPECT_THAT(complaint({"inspect", map()}, 67), Not(HasSubstr("this is a compiled map")));
  EXPECT_THAT(complaint({"compile", write("bad.yaml", "mapping: [\n")}, 65),
              AllOf(HasSubstr("SL2020"), Not(HasSubstr("this is"))));
  const Error other{ErrorCode::kCannotRead, "input/output error", map()};
  EXPECT_EQ(explain_wrong_file(other).message, other.message);
}

TEST(SetFlag, SaysWhatItsPathsAreRelativeTo) {
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(run_command_line(sightline_program(), {"compile", "--help"}), 0);
  EXPECT_THAT(::testing::internal::GetCapturedStdout(), HasSubstr("relative to the current"));
}

}  // namespace
}  // namespace sightline
