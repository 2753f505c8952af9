#include "formats/foreign/recording/same_recording.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "formats/foreign/recording/open_recording.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class SameRecording : public testing::Test {
 protected:
  RecordingOptions options(const std::string& path) {
    RecordingOptions made;
    made.scans = (folder_ / path).string();
    return made;
  }
  bool is_same(const std::string& a, const std::string& b) {
    const bool is = is_same_recording(options(a), options(b));
    EXPECT_EQ(is_same_recording(options(b), options(a)), is);
    return is;
  }

  ScratchFolder folder_;
};

std::string scan_of(const std::string& point) {
  return "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
         "POINTS 1\nDATA ascii\n" +
         point + "\n";
}

TEST_F(SameRecording, IsOnePlaceByEachOfItsPathsAndACopy) {
  for (const char* file : {"a/1.pcd", "copy/001.pcd", "longer/1.pcd", "changed/1.pcd"}) {
    folder_.write(file, scan_of("1 2 3"));
  }
  for (const char* file : {"a/2.pcd", "copy/002.pcd", "longer/2.pcd"}) {
    folder_.write(file, scan_of("4 5 6"));
  }
  folder_.write("changed/2.pcd", scan_of("4 5 7"));
  folder_.write("longer/3.pcd", scan_of("7 8 9"));
  fs::create_directory_symlink(folder_ / "a", folder_ / "link");
  for (const char* same : {"a", "a/", "a//", "copy/../a", "link", "link/", "copy"}) {
    EXPECT_TRUE(is_same("a", same)) << same;
  }
  for (const char* other : {"longer", "changed", "", "nowhere"}) {
    EXPECT_FALSE(is_same("a", other)) << other;
  }
  EXPECT_TRUE(is_same("nowhere", "a/../nowhere/"));
  EXPECT_FALSE(is_same("nowhere", "nowhere else"));
}

TEST_F(SameRecording, TopicsOfOneBagAreDifferentRecordings) {
  RecordingOptions front = options("drive.bag");
  RecordingOptions rear = front;
  EXPECT_TRUE(is_same_recording(front, rear));
  front.topic = "/front";
  EXPECT_TRUE(is_same_recording(front, rear)) << "its only one";
  rear.topic = "/rear";
  EXPECT_FALSE(is_same_recording(front, rear));
}

TEST_F(SameRecording, ContentsNameScansWhateverElseARecordingHas) {
  for (const char* file : {"a/1.pcd", "b/7.pcd"}) folder_.write(file, scan_of("1 2 3"));
  folder_.write("c/1.pcd", scan_of("1 2 4"));
  RecordingOptions b = options("b");
  b.name = "other";
  b.sensor = "vlp-16";
  b.poses = folder_.write("poses.txt", "5 1 2 3 0 0 0 1\n").string();
  const auto digest_of = [](const RecordingOptions& of) {
    return scans_digest(value_of(open_recording(of)));
  };
  EXPECT_EQ(digest_of(options("a")), digest_of(b));
  EXPECT_NE(digest_of(options("a")), digest_of(options("c")));
}

class TestMemory : public DigestMemory {
 public:
  [[nodiscard]] std::optional<std::vector<std::byte>> load(const Digest& key) const override {
    const auto found = kept_.find(key);
    if (found == kept_.end()) return std::nullopt;
    ++hits;
    return found->second;
  }
  void store(const Digest& key, std::span<const std::byte> content) const override {
    kept_[key] = {content.begin(), content.end()};
  }
  std::map<Digest, std::vector<std::byte>>& kept() { return kept_; }
  mutable int hits = 0;

 private:
  mutable std::map<Digest, std::vector<std::byte>> kept_;
};

class RememberedDigests : public testing::Test {
 protected:
  RememberedDigests() {
    for (const char* name : {"scans/0.bin", "scans/1.bin", "scans/2.bin"}) write(name, 2400);
    options_.scans = (folder_ / "scans").string();
  }
  void write(const char* name, std::size_t count) { folder_.write(name, float_spiral(5, count)); }
  Recording open() { return value_of(open_recording(options_, 1, &memory_)); }
  static void let_files_settle() { std::this_thread::sleep_for(std::chrono::milliseconds(2100)); }

  ScratchFolder folder_;
  RecordingOptions options_;
  TestMemory memory_;
};

TEST_F(RememberedDigests, OfFilesThatWereJustWrittenAreNotKept) {
  open();
  EXPECT_TRUE(memory_.kept().empty());
}

TEST_F(RememberedDigests, GiveTheSameRecordingWithoutReadingItsFiles) {
  let_files_settle();
  const Recording first = open();
  ASSERT_EQ(memory_.kept().size(), 1U);
  const Recording again = open();
  EXPECT_EQ(memory_.hits, 1);
  EXPECT_EQ(again.digest, first.digest);
  EXPECT_EQ(again.warnings, first.warnings);
  EXPECT_FALSE(first.warnings.empty());
  EXPECT_TRUE(read_recorded_scan(again, 1).has_value());
  // They are believed, and a scan that is not what they say is refused when it is read.
  memory_.kept().begin()->second.at(8) ^= std::byte{1};    // in the first SHA-256
  memory_.kept().begin()->second.at(112) ^= std::byte{1};  // in the first XXH3
  const Recording wrong = open();
  EXPECT_NE(wrong.digest, first.digest);
  EXPECT_EQ(read_recorded_scan(wrong, 0).error().code, ErrorCode::kMismatchedInputs);
  EXPECT_TRUE(read_recorded_scan(wrong, 1).has_value());
}

TEST_F(RememberedDigests, AreNotBelievedOfAFileThatWasWrittenToAndGivenItsOldTimes) {
  let_files_settle();
  const Recording first = open();
  struct stat before {};
  ASSERT_EQ(::stat((folder_ / "scans/1.bin").c_str(), &before), 0);
  std::string other = float_spiral(5, 2400);
  other[16] = static_cast<char>(other[16] ^ 1);
  folder_.write("scans/1.bin", other);
  const timespec times[] = {before.st_atim, before.st_mtim};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder_ / "scans/1.bin").c_str(), times, 0), 0);
  const Recording changed = open();
  EXPECT_EQ(memory_.hits, 0);
  EXPECT_NE(changed.digest, first.digest);
}

TEST_F(RememberedDigests, ThatAreDamagedAreReadAgain) {
  let_files_settle();
  const Recording first = open();
  const std::vector<std::byte> whole = memory_.kept().begin()->second;
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    memory_.kept().begin()->second.assign(whole.begin(),
                                          whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(open().digest, first.digest) << size;
  }
}

}  // namespace
}  // namespace sightline
