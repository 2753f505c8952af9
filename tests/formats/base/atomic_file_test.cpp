#include "formats/base/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

namespace sightline {
namespace {

class AtomicFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::size_t file_count() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      count += entry.is_regular_file() ? 1 : 0;
    }
    return count;
  }
  std::filesystem::path folder_;
};

TEST_F(AtomicFile, AppearsWholeAndLeavesNothingBeside) {
  const std::filesystem::path path = folder_ / "deep" / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("content"), IfExists::kRefuse));
  const Result<std::string> text = read_text_file(path);
  ASSERT_TRUE(text);
  EXPECT_EQ(*text, "content");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "deep"), {}), 1);
}

TEST_F(AtomicFile, IsNotReplacedUnlessAsked) {
  const std::filesystem::path path = folder_ / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("old"), IfExists::kRefuse));
  const Result<void> refused =
      write_file_atomically(path, std::string_view("new"), IfExists::kRefuse);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutputExists);
  EXPECT_EQ(*read_text_file(path), "old");
  ASSERT_TRUE(write_file_atomically(path, std::string_view("new"), IfExists::kReplace));
  EXPECT_EQ(*read_text_file(path), "new");
}

// A limit on the size of files stands for a full disk: write() fails half-way in both.
TEST_F(AtomicFile, LeavesTheOldFileWhenWritingFailsHalfWay) {
  const std::filesystem::path path = folder_ / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("old"), IfExists::kRefuse));
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Result<void> result =
      write_file_atomically(path, std::string(100'000, 'x'), IfExists::kReplace);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  ASSERT_FALSE(result);
  EXPECT_EQ(error_class(result.error().code), ErrorClass::kSystem);
  EXPECT_EQ(*read_text_file(path), "old");
  EXPECT_EQ(file_count(), 1U);
}

TEST_F(AtomicFile, SaysWhichFileIsNotThere) {
  const Result<std::vector<std::byte>> missing = read_file(folder_ / "nothing");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(missing.error().file, (folder_ / "nothing").string());
}

}  // namespace
}  // namespace sightline
