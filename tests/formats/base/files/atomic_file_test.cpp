#include "formats/base/files/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <filesystem>

#include "tests/support/scratch_folder.h"
#include "tests/support/test_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

class AtomicFile : public TestInFolder {
 protected:
  std::size_t file_count() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      count += entry.is_regular_file() ? 1 : 0;
    }
    return count;
  }
};

TEST_F(AtomicFile, AppearsWholeAndLeavesNothingBeside) {
  const std::filesystem::path path = folder_ / "deep" / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("content"), IfExists::kRefuse));
  EXPECT_EQ(value_of(read_text_file(path)), "content");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "deep"), {}), 1);
}

TEST_F(AtomicFile, IsNotReplacedUnlessAsked) {
  const std::filesystem::path path = folder_ / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("old"), IfExists::kRefuse));
  EXPECT_EQ(code_of(write_file_atomically(path, std::string_view("new"), IfExists::kRefuse)),
            ErrorCode::kOutputExists);
  EXPECT_EQ(*read_text_file(path), "old");
  ASSERT_TRUE(write_file_atomically(path, std::string_view("new"), IfExists::kReplace));
  EXPECT_EQ(*read_text_file(path), "new");
}

// A limit on the size of files stands for a full disk: write() fails half-way in both.
TEST_F(AtomicFile, LeavesTheOldFileWhenWritingFailsHalfWay) {
  const std::filesystem::path path = folder_ / "map.bin";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("old"), IfExists::kRefuse));
  const auto write_on_full_disk = [&] {
    const NoLargeFiles full_disk;
    return write_file_atomically(path, std::string(100'000, 'x'), IfExists::kReplace);
  };
  EXPECT_EQ(code_of(write_on_full_disk()), ErrorCode::kDiskFull);
  EXPECT_EQ(*read_text_file(path), "old");
  EXPECT_EQ(file_count(), 1U);
}

TEST_F(AtomicFile, OnlyARegularFileIsReplaced) {
  const std::filesystem::path victim = folder_ / "victim";
  ASSERT_TRUE(write_file_atomically(victim, std::string_view("precious"), IfExists::kRefuse));
  std::filesystem::create_symlink(victim, folder_ / "link");
  std::filesystem::create_symlink(folder_ / "nowhere", folder_ / "dangling");
  std::filesystem::create_directories(folder_ / "folder");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  for (const IfExists if_exists : {IfExists::kRefuse, IfExists::kReplace}) {
    for (const char* name : {"link", "dangling", "folder", "pipe", "/dev/null"}) {
      EXPECT_EQ(failure_of(
                    write_file_atomically(folder_ / name, std::string_view("new"), if_exists), name)
                    .code,
                ErrorCode::kCannotWrite)
          << name;
    }
  }
  EXPECT_EQ(*read_text_file(victim), "precious");
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_EQ(file_count(), 2U) << "the victim, by its name and by the link";
}

TEST_F(AtomicFile, OfASecretIsReadableByItsOwnerAlone) {
  const std::filesystem::path path = folder_ / "secret";
  ASSERT_TRUE(
      write_file_atomically(path, std::string_view("x"), IfExists::kRefuse, FileAccess::kOwner));
  EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms(0600));
}

TEST_F(AtomicFile, KeepsTheModeOfTheFileThatItReplaces) {
  namespace fs = std::filesystem;
  const fs::path path = folder_ / "shared";
  for (const unsigned mode : {0664U, 0600U, 0640U, 0666U}) {
    fs::remove(path);
    ASSERT_TRUE(write_file_atomically(path, std::string_view("old"), IfExists::kRefuse));
    fs::permissions(path, fs::perms(mode));
    ASSERT_TRUE(write_file_atomically(path, std::string_view("new"), IfExists::kReplace));
    EXPECT_EQ(fs::status(path).permissions(), fs::perms(mode));
    // A secret is never readable by more than its owner.
    ASSERT_TRUE(write_file_atomically(path, std::string_view("secret"), IfExists::kReplace,
                                      FileAccess::kOwner));
    EXPECT_EQ(fs::status(path).permissions(), fs::perms(0600));
  }
}

TEST_F(AtomicFile, CannotHaveANameThatIsTooLong) {
  const std::filesystem::path path = folder_ / std::string(300, 'n');
  EXPECT_EQ(failure_of(check_output(path, IfExists::kReplace)).code, ErrorCode::kCannotWrite);
  EXPECT_TRUE(check_output(folder_ / "short", IfExists::kReplace));
}

TEST_F(AtomicFile, NamesTheFolderThatCannotBeMade) {
  ASSERT_TRUE(write_file_atomically(folder_ / "file", std::string_view("x"), IfExists::kRefuse));
  const std::filesystem::path folder = folder_ / "file" / "below";
  const Error error =
      failure_of(write_file_atomically(folder / "map", std::string_view("x"), IfExists::kRefuse));
  EXPECT_EQ(error.code, ErrorCode::kCannotWrite);
  EXPECT_EQ(error.file, folder.string());
}

TEST_F(AtomicFile, ThatMemoryCannotHoldIsRefusedByName) {
  const std::filesystem::path path = folder_ / "hole";
  ASSERT_TRUE(write_file_atomically(path, std::string_view(""), IfExists::kRefuse));
  std::filesystem::resize_file(path, 100'000'000'000);
  rlimit before{};
  ::getrlimit(RLIMIT_AS, &before);
  const rlimit small{rlim_t{8} << 30, before.rlim_max};
  ::setrlimit(RLIMIT_AS, &small);
  const Result<std::string> text = read_text_file(path);
  ::setrlimit(RLIMIT_AS, &before);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kOutOfMemory);
  EXPECT_EQ(text.error().file, path.string());
}

TEST_F(AtomicFile, ShortTextsAreReadNoFurtherThanTheirLimit) {
  const std::filesystem::path path = folder_ / "text";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("12345"), IfExists::kRefuse));
  EXPECT_EQ(*read_short_text(path, 5), "12345");
  EXPECT_EQ(read_short_text(path, 4).error().code, ErrorCode::kTooLarge);
}

TEST_F(AtomicFile, SaysWhichFileIsNotThere) {
  const Error error = failure_of(read_file(folder_ / "nothing"));
  EXPECT_EQ(error.code, ErrorCode::kFileNotFound);
  EXPECT_EQ(error.file, (folder_ / "nothing").string());
}

}  // namespace
}  // namespace sightline
