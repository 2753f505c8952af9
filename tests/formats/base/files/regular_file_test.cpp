#include "formats/base/files/regular_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class RegularFiles : public TestInFolder {};

TEST_F(RegularFiles, AreReadFromTheirBeginning) {
  const std::string file = folder_ / "text";
  std::ofstream(file) << "0123456789";
  EXPECT_EQ(open_regular_file(file)->size, 10U);
  EXPECT_EQ(*read_beginning(file, 4), "0123");
  EXPECT_EQ(*read_beginning(file, 100), "0123456789");
  EXPECT_EQ(*read_beginning(file, 0), "");
}

// A pipe without a writer would wait for ever; this test would too.
TEST_F(RegularFiles, AloneAreOpened) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, std::string("/dev/null"), std::string("/dev/zero"),
                                  std::string("/dev/tty"), folder_.string()}) {
    const Error error = failure_of(read_beginning(path, 4), path);
    EXPECT_EQ(error_class(error.code), ErrorClass::kSystem) << path;
    EXPECT_EQ(error.file, path);
  }
  EXPECT_EQ(open_regular_file(folder_ / "missing").error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace sightline
