#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>

#include "formats/base/huge_pages.h"

namespace sightline {
namespace {

bool begins_a_page(const void* block) {
  return reinterpret_cast<std::uintptr_t>(block) % kHugePage_bytes == 0;
}

TEST(LargeBlocks, BeginALargePageAndHoldWhatIsPutThere) {
  constexpr std::size_t kSizes[] = {2 * kHugePage_bytes, 2 * kHugePage_bytes + 1,
                                    5 * kHugePage_bytes / 2, 7 * kHugePage_bytes - 1};
  for (const std::size_t size : kSizes) {
    auto* const block = static_cast<std::uint8_t*>(::operator new(size));
    EXPECT_TRUE(begins_a_page(block)) << size;
    const std::span<std::uint8_t> bytes(block, size);
    for (std::size_t i = 0; i < size; i += 1000) bytes[i] = static_cast<std::uint8_t>(i / 1000);
    bytes.back() = 7;
    std::size_t wrong = 0;
    for (std::size_t i = 0; i + 1 < size; i += 1000) {
      wrong += bytes[i] == static_cast<std::uint8_t>(i / 1000) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0U);
    EXPECT_EQ(bytes.back(), 7);
    ::operator delete(block);
  }
}

// Of a hundred not all lie at the begin of 2 MiB by chance.
TEST(LargeBlocks, SmallOnesLieWhereMallocPutsThem) {
  void* blocks[100];
  for (void*& block : blocks) block = ::operator new(kHugePage_bytes / 2);
  EXPECT_FALSE(std::ranges::all_of(blocks, begins_a_page));
  for (void* block : blocks) ::operator delete(block);
  void* const none = ::operator new(0);
  EXPECT_NE(none, nullptr);
  ::operator delete(none);
}

// Kept, so that no compiler leaves out a block that is not used.
void* volatile kept = nullptr;

TEST(LargeBlocks, WhatNoAddressesAreLeftForIsBadAlloc) {
  for (const std::size_t size : {std::size_t{1} << 47, std::size_t{1} << 62, SIZE_MAX}) {
    EXPECT_THROW(kept = ::operator new(size), std::bad_alloc) << size;
  }
}

int calls_of_handler = 0;

TEST(LargeBlocks, AskTheHandlerBeforeTheyFail) {
  calls_of_handler = 0;
  std::set_new_handler([] {
    if (++calls_of_handler == 3) std::set_new_handler(nullptr);
  });
  EXPECT_THROW(kept = ::operator new (std::size_t{1} << 47), std::bad_alloc);
  EXPECT_EQ(calls_of_handler, 3);
}

}  // namespace
}  // namespace sightline
