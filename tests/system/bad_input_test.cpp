#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class BadInput : public ::testing::Test {
 protected:
  void write_drive() {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "scans");
    pose_lines_.clear();
    for (int i = 0; i < kScans; ++i) {
      const std::string name = "00000" + std::to_string(i) + ".pcd";
      fs::copy(small_town() / "mapping" / "scans" / name, folder_ / "scans" / name);
    }
    std::ifstream poses(small_town() / "mapping" / "poses.tum");
    std::string line;
    for (int i = 0; i < kScans && std::getline(poses, line);) {
      if (line.starts_with("#")) continue;
      pose_lines_.push_back(line);
      ++i;
    }
    write_poses();
    write("drive.yaml", "mapping: {scans: scans, poses: poses.tum}\n");
  }
  void write(const fs::path& name, const std::string& text) const {
    ASSERT_TRUE(write_file_atomically(folder_ / name, text, IfExists::kReplace));
  }
  void write_poses() const {
    std::string text;
    for (const std::string& line : pose_lines_) text += line + "\n";
    write("poses.tum", text);
  }
  void expect_refused(int status, const std::string& code, const std::string& mention) const {
    const ProgramResult run =
        run_sightline("compile " + (folder_ / "drive.yaml").string() + " -q --no-cache -o " +
                      (folder_ / "out.slmap").string());
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_NE(run.err.find(code), std::string::npos) << run.err;
    EXPECT_NE(run.err.find(mention), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(folder_ / "out.slmap"));
  }

  static constexpr int kScans = 5;
  const fs::path folder_ = fresh_folder();
  std::vector<std::string> pose_lines_;
};

TEST_F(BadInput, IsRefusedWithItsCodeAndFile) {
  struct Fault {
    std::function<void()> spoil;
    int status;
    const char* code;
    const char* mention;
  };
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:" + std::string(64, 'a') +
      "\nsize 12345\n";
  const fs::path scan = folder_ / "scans/000001.pcd";
  const auto with_pose = [&](std::size_t line, const char* pose) {
    pose_lines_[line] = pose;
    write_poses();
  };
  const std::vector<Fault> faults = {
      {[&] { write("scans/000002.pcd", pointer); }, 65, "SL2003 git-lfs-pointer", "000002.pcd"},
      {[&] { write("scans/000003.pcd", ""); }, 65, "SL20", "000003.pcd"},
      {[&] { fs::resize_file(scan, fs::file_size(scan) - 7); }, 65, "SL2006 truncated-scan",
       "000001.pcd"},
      {[&] {
         fs::remove_all(folder_ / "scans");
         fs::create_directories(folder_ / "scans");
       },
       65, "SL2002 empty-directory", "scans"},
      {[&] {
         pose_lines_.pop_back();
         write_poses();
       },
       65, "SL2010 fewer-poses-than-scans", "poses.tum"},
      {[&] { with_pose(2, "2.0 1 2 0 0.5 0.5 0.5 0.9"); }, 65, "SL2011 not-a-rotation", "line 3"},
      {[&] { with_pose(1, "0.1 1 two 0 0 0 0 1"); }, 65, "SL2009 malformed-pose", "line 2"},
      {[&] {
         std::swap(pose_lines_[1], pose_lines_[3]);
         write_poses();
       },
       65, "SL2012 time-runs-backwards", "poses.tum"},
      {[&] { write("drive.yaml", "mapping: {scans: skans}\n"); }, 65, "SL2001 file-not-found",
       "skans"},
      {[&] { write("drive.yaml", "mapping: {scans: scans}\nbuild-ndt: {cel_m: 1.0}\n"); }, 64,
       "SL1002 unknown-key", "did you mean 'cell_m'?"}};
  for (const Fault& fault : faults) {
    write_drive();
    fault.spoil();
    expect_refused(fault.status, fault.code, fault.mention);
  }
}

TEST_F(BadInput, AFileThatIsNoMap) {
  write("other.slmap", "this is no map at all, but long enough to hold a header of 128 bytes" +
                           std::string(200, '.'));
  const ProgramResult run = run_sightline("verify " + (folder_ / "other.slmap").string());
  EXPECT_EQ(run.status, 67) << run.err;
  EXPECT_NE(run.err.find("SL4001 bad-magic"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace sightline
