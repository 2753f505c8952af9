// Several processes at one map. The functions below take the place of the C library's, so that
// another process may come in between at the worst moment.

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/delta/part_file.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace {

std::function<void()> before_lock;  // in its place it is called once
std::function<void(const char* from)> before_rename;

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int flock(int file, int operation) noexcept {
  if (before_lock) std::exchange(before_lock, nullptr)();
  return real<int (*)(int, int)>("flock")(file, operation);
}
extern "C" int rename(const char* from, const char* to) noexcept {
  if (before_rename) before_rename(from);
  return real<int (*)(const char*, const char*)>("rename")(from, to);
}

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

class ApplyTogether : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = scratch_folder();
    fs::create_directories(folder_);
    const CompiledMap map = random_map({.seed = 2, .site_count = 8, .nd_count = 30});
    base_ = encode_map(map);
    for (std::size_t i = 0; i < results_.size(); ++i) {
      results_[i] = encode_map(changed_map(map, 1 + i));
      write(delta(i), *make_delta(base_, results_[i], DeltaOptions()));
    }
    map_ = folder_ / "town.slmap";
    write(map_, base_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  static void write(const fs::path& path, const Bytes& bytes) {
    ASSERT_TRUE(write_file_atomically(path, bytes, IfExists::kReplace));
  }
  [[nodiscard]] fs::path delta(std::size_t i) const {
    return folder_ / (std::to_string(i) + ".sldelta");
  }
  [[nodiscard]] int apply_all() const {
    std::array<pid_t, 3> children{};
    for (std::size_t i = 0; i < children.size(); ++i) {
      children[i] = ::fork();
      if (children[i] == 0) ::_exit(apply_delta(delta(i), map_) ? 0 : 1);
    }
    int done = 0;
    for (const pid_t child : children) {
      int status = 0;
      ::waitpid(child, &status, 0);
      done += WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 1 : 0;
    }
    return done;
  }

  fs::path folder_;
  fs::path map_;
  Bytes base_;
  std::array<Bytes, 3> results_;
};

TEST_F(ApplyTogether, OneWinsAndTheMapIsWhole) {
  constexpr int kRounds = 60;
  for (int round = 0; round < kRounds; ++round) {
    write(map_, base_);
    ASSERT_EQ(apply_all(), 1) << round;
    const auto whole = std::ranges::find(results_, *read_file(map_));
    ASSERT_TRUE(whole != results_.end()) << "round " << round << ": the map is torn";
    ASSERT_TRUE(*read_file(previous_path(map_)) == base_) << round;
    ASSERT_FALSE(fs::exists(part_path(map_))) << round;
  }
}

// Whoever opened the part before it became the map would write into the map.
TEST_F(ApplyTogether, APartThatBecameTheMapBeforeItWasLockedIsLeftAlone) {
  write(part_path(map_), Bytes());
  before_lock = [&] { fs::rename(part_path(map_), folder_ / "done"); };
  EXPECT_EQ(failure_of(PartFile::open(part_path(map_))).code, ErrorCode::kCannotOpen);
  EXPECT_TRUE(fs::exists(folder_ / "done"));
}

TEST_F(ApplyTogether, TheLockIsHeldWhileThePartBecomesTheMap) {
  int renames = 0;
  before_rename = [&](const char* from) {
    if (part_path(map_) != from) return;
    const int other = ::open(from, O_RDWR | O_CLOEXEC);
    const auto lock = real<int (*)(int, int)>("flock");
    renames += lock(other, LOCK_EX | LOCK_NB) != 0 ? 1 : 0;
    ::close(other);
  };
  const Result<ApplyReport> report = apply_delta(delta(0), map_);
  before_rename = nullptr;
  ASSERT_TRUE(report);
  EXPECT_EQ(renames, 1);
}

TEST_F(ApplyTogether, TheBaseIsLookedAtAgainUnderTheLock) {
  before_lock = [&] { write(map_, results_[1]); };
  EXPECT_EQ(apply_delta(delta(0), map_).error().code, ErrorCode::kWrongBase);
  EXPECT_TRUE(*read_file(map_) == results_[1]);
}

TEST_F(ApplyTogether, ThePartIsLockedUnderAnyName) {
  const PartFile first = value_of(PartFile::open(part_path(map_)));
  EXPECT_EQ(apply_delta(delta(0), map_).error().code, ErrorCode::kCannotOpen);
  // Renamed while it is locked, as the last step of an apply does: another part may begin.
  fs::rename(part_path(map_), folder_ / "done");
  EXPECT_TRUE(apply_delta(delta(0), map_));
  EXPECT_TRUE(*read_file(map_) == results_[0]);
}

TEST_F(ApplyTogether, ARefusedDeltaLeavesNothing) {
  ASSERT_TRUE(apply_delta(delta(0), map_));
  EXPECT_EQ(apply_delta(delta(1), map_).error().code, ErrorCode::kWrongBase);
  EXPECT_FALSE(fs::exists(part_path(map_)));
  ASSERT_TRUE(roll_back(map_));
  EXPECT_FALSE(fs::exists(part_path(map_)));
  EXPECT_TRUE(*read_file(map_) == base_);
}

}  // namespace
}  // namespace sightline
