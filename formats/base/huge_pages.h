#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace sightline {

inline constexpr std::size_t kHugePage_bytes = std::size_t{2} << 20;

// A block of so many bytes, which std::free() takes back, on large pages where the system has them
// and gives them to who asks; null where there is no memory. The last page is a large one where the
// block fills half of it.
inline void* allocate_on_huge_pages(std::size_t size) {
  const std::size_t pages = (size + kHugePage_bytes - 1) / kHugePage_bytes;
  void* const block = std::aligned_alloc(kHugePage_bytes, pages * kHugePage_bytes);
  if (block == nullptr) return nullptr;
  const std::size_t large = (size + kHugePage_bytes / 2) / kHugePage_bytes;
  (void)::madvise(block, large * kHugePage_bytes, MADV_HUGEPAGE);  // advice: small pages serve too
  return block;
}

// Memory of std::allocator, but in large pages where the system has them and the array is long:
// each page that is met at random costs a walk through the page tables, inside a virtual machine
// through two of them. Values and order are those of any other vector.
template <class T>
struct HugePageAllocator {
  using value_type = T;

  HugePageAllocator() = default;
  template <class Other>
  explicit(false) HugePageAllocator(const HugePageAllocator<Other>&) {}

  T* allocate(std::size_t count) {
    if (!is_long(count)) return std::allocator<T>().allocate(count);
    void* const memory = allocate_on_huge_pages(count * sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (!is_long(count)) return std::allocator<T>().deallocate(memory, count);
    std::free(memory);
  }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }

 private:
  // From one page on; more than any memory holds is left to the other allocator's error.
  static bool is_long(std::size_t count) {
    return count >= kHugePage_bytes / sizeof(T) && count < (std::size_t{1} << 46) / sizeof(T);
  }
};

// For what is large and read at random.
template <class T>
using HugeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace sightline
