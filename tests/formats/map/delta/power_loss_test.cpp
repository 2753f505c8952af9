// The process ends in the middle of apply, at every call that changes something on the disk; the
// functions below take the place of the C library's.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/scratch_folder.h"

namespace {

long calls_left = -1;  // below 0: no end

bool ends_here() { return calls_left >= 0 && calls_left-- == 0; }

constexpr int kPowerLost = 9;

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

// With the call done, or not: the disk may have seen it or not.
template <class F>
int end_or_call(const F& call) {
  if (!ends_here()) return call();
  if (calls_left % 2 == 0) (void)call();
  ::_exit(kPowerLost);
}

}  // namespace

extern "C" ssize_t pwrite(int file, const void* data, std::size_t size, off_t offset) {
  using Function = ssize_t (*)(int, const void*, std::size_t, off_t);
  if (!ends_here()) return real<Function>("pwrite")(file, data, size, offset);
  (void)real<Function>("pwrite")(file, data, size / 2, offset);
  ::_exit(kPowerLost);
}
extern "C" int ftruncate(int file, off_t size) noexcept {
  return end_or_call([&] { return real<int (*)(int, off_t)>("ftruncate")(file, size); });
}
extern "C" int fsync(int file) {
  return end_or_call([&] { return real<int (*)(int)>("fsync")(file); });
}
extern "C" int rename(const char* from, const char* to) noexcept {
  return end_or_call([&] { return real<int (*)(const char*, const char*)>("rename")(from, to); });
}
extern "C" int link(const char* from, const char* to) noexcept {
  return end_or_call([&] { return real<int (*)(const char*, const char*)>("link")(from, to); });
}
extern "C" int unlink(const char* path) noexcept {
  return end_or_call([&] { return real<int (*)(const char*)>("unlink")(path); });
}

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

class PowerLoss : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    const CompiledMap map = random_map({.seed = 2, .site_count = 8, .nd_count = 30});
    base_ = encode_map(map);
    result_ = encode_map(changed_map(map, 1));
    write(delta_, *make_delta(base_, result_, DeltaOptions()));
  }
  void TearDown() override { fs::remove_all(folder_); }

  static void write(const fs::path& path, const Bytes& bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  int apply_until(long call) const {
    const pid_t child = ::fork();
    if (child == 0) {
      calls_left = call;
      ::_exit(apply_delta(delta_, map_) ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WEXITSTATUS(status);
  }

  fs::path folder_ = scratch_folder();
  fs::path map_ = folder_ / "town.slmap";
  fs::path delta_ = folder_ / "town.sldelta";
  Bytes base_;
  Bytes result_;
};

TEST_F(PowerLoss, AtAnyCallLeavesTheOldMapOrTheNewOneAndApplyGoesOn) {
  int status = kPowerLost;
  long call = 0;
  for (; status == kPowerLost; ++call) {
    SCOPED_TRACE(call);
    fs::remove(part_path(map_));
    fs::remove(previous_path(map_));
    write(map_, base_);
    status = apply_until(call);
    ASSERT_NE(status, 1);
    const Bytes found = *read_file(map_);
    ASSERT_TRUE(found == base_ || found == result_);
    ASSERT_EQ(apply_until(-1), 0);
    ASSERT_TRUE(*read_file(map_) == result_);
    // Unless it was lost after the map was in place, the old one is kept.
    ASSERT_TRUE(*read_file(previous_path(map_)) == base_);
    ASSERT_FALSE(fs::exists(part_path(map_)));
  }
  EXPECT_GT(call, 10) << "the calls are not counted";
}

TEST_F(PowerLoss, ManyTimesOverComesToAnEnd) {
  write(map_, base_);
  int status = kPowerLost;
  for (long call = 1; status == kPowerLost; ++call) status = apply_until(call % 12);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(*read_file(map_) == result_);
}

}  // namespace
}  // namespace sightline
