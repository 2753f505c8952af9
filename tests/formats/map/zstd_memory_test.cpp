// Memory that runs out inside zstd. The functions below take the place of the library's.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <filesystem>
#include <fstream>
#include <new>

#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/changed_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace {

bool has_no_memory = false;

template <class F>
F real(const char* name) {
  return reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
}

constexpr std::size_t kNoMemory = static_cast<std::size_t>(-ZSTD_error_memory_allocation);

}  // namespace

extern "C" {
size_t ZSTD_decompress(void* to, size_t room, const void* from, size_t size) {
  if (has_no_memory) return kNoMemory;
  return real<size_t (*)(void*, size_t, const void*, size_t)>("ZSTD_decompress")(to, room, from,
                                                                                 size);
}
size_t ZSTD_compress(void* to, size_t room, const void* from, size_t size, int level) {
  if (has_no_memory) return kNoMemory;
  return real<size_t (*)(void*, size_t, const void*, size_t, int)>("ZSTD_compress")(to, room, from,
                                                                                    size, level);
}
ZSTD_DCtx* ZSTD_createDCtx() {
  return has_no_memory ? nullptr : real<ZSTD_DCtx* (*)()>("ZSTD_createDCtx")();
}
ZSTD_CCtx* ZSTD_createCCtx() {
  return has_no_memory ? nullptr : real<ZSTD_CCtx* (*)()>("ZSTD_createCCtx")();
}
}

namespace sightline {
namespace {

class ZstdMemory : public ::testing::Test {
 protected:
  ~ZstdMemory() override { has_no_memory = false; }
};

// A sound map is not called damaged, and no other bytes are written in place of packed ones.
TEST_F(ZstdMemory, ThatIsMissingIsNoDamageOfAMap) {
  const CompiledMap map = random_map({.seed = 2, .site_count = 300, .nd_count = 900});
  const std::vector<std::byte> bytes = encode_map(map);
  ASSERT_TRUE(verify_map(bytes));
  has_no_memory = true;
  EXPECT_THROW((void)verify_map(bytes), std::bad_alloc);
  EXPECT_THROW((void)encode_map(map), std::bad_alloc);
}

TEST_F(ZstdMemory, ThatIsMissingIsNoDamageOfADelta) {
  const CompiledMap map = random_map({.seed = 2, .site_count = 300, .nd_count = 900});
  const std::vector<std::byte> before = encode_map(map);
  const std::vector<std::byte> after = encode_map(changed_map(map, 1));
  has_no_memory = true;
  EXPECT_THROW((void)make_delta(before, after, {}), std::bad_alloc);
}

}  // namespace
}  // namespace sightline
