#include "formats/foreign/recording/same_recording.h"

#include <filesystem>

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
    const Result<Recording> recording = open_recording(of);
    EXPECT_TRUE(recording) << to_string(recording.error());
    return scans_digest(*recording);
  };
  EXPECT_EQ(digest_of(options("a")), digest_of(b));
  EXPECT_NE(digest_of(options("a")), digest_of(options("c")));
}

}  // namespace
}  // namespace sightline
