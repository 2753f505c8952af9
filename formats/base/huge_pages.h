#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace sightline {

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
    const std::size_t size = (count * sizeof(T) + kPage - 1) / kPage * kPage;
    void* const memory = std::aligned_alloc(kPage, size);
    if (memory == nullptr) throw std::bad_alloc();
    (void)::madvise(memory, size, MADV_HUGEPAGE);  // advice: small pages serve as well
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (!is_long(count)) return std::allocator<T>().deallocate(memory, count);
    std::free(memory);
  }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;
  // From one page on; more than any memory holds is left to the other allocator's error.
  static bool is_long(std::size_t count) {
    return count >= kPage / sizeof(T) && count < (std::size_t{1} << 46) / sizeof(T);
  }
};

// For what is large and read at random.
template <class T>
using HugeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace sightline
