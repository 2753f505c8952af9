#include <cstdlib>
#include <new>

#include "formats/base/huge_pages.h"

// The program's operator new: large blocks are on large pages, since passes read hundreds of
// megabytes of tables in random order, and a processor remembers the places of a few thousand
// pages. The rest is malloc()'s; std::free() frees both. Libraries leave this to their user.

namespace {

// So that the last page, of which a half may lie idle, is no more than a quarter.
constexpr std::size_t kLarge_bytes = 2 * sightline::kHugePage_bytes;
// More than any memory holds, and far from where rounding up to pages would begin anew.
constexpr std::size_t kTooLarge_bytes = std::size_t{1} << 46;

void* allocate(std::size_t size) {
  const bool is_large = size >= kLarge_bytes && size < kTooLarge_bytes;
  return is_large ? sightline::allocate_on_huge_pages(size) : std::malloc(size == 0 ? 1 : size);
}

}  // namespace

void* operator new(std::size_t size) {
  for (;;) {
    if (void* block = allocate(size)) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
