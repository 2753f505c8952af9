#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <new>

// The program's operator new: large blocks lie on huge pages, where the system gives them to those
// who ask (most Linux systems). A pass fills hundreds of megabytes of tables and looks into them
// anywhere; of 4 KiB pages the system must give a quarter of a million, and a processor remembers
// where a few thousand of them are. All else is malloc(), and so is what frees. Of libraries the
// user decides himself, so this is in none.

namespace {

constexpr std::size_t kHugePage_bytes = std::size_t{2} << 20;
// Twice the most that rounding up may waste.
constexpr std::size_t kLargeBlock_bytes = 2 * kHugePage_bytes;

void* allocate(std::size_t size) {
  if (size < kLargeBlock_bytes || size > SIZE_MAX - kHugePage_bytes) {
    return std::malloc(size == 0 ? 1 : size);
  }
  const std::size_t pages = (size + kHugePage_bytes - 1) / kHugePage_bytes;
  void* block = std::aligned_alloc(kHugePage_bytes, pages * kHugePage_bytes);
#ifdef MADV_HUGEPAGE
  // Not the last one if it would be half empty. A system that knows no huge pages says so, and all
  // is as it was.
  if (block != nullptr) {
    const std::size_t whole = (size + kHugePage_bytes / 2) / kHugePage_bytes;
    ::madvise(block, whole * kHugePage_bytes, MADV_HUGEPAGE);
  }
#endif
  return block;
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
