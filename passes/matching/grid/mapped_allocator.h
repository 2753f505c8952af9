#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "formats/base/huge_pages.h"

namespace sightline {

// So many bytes of pages of their own, aligned to a large page, on large pages where the system has
// them; null where there is no memory. unmap_pages() returns them to the system at once.
inline void* map_pages(std::size_t size) {
  const std::size_t room = size + kHugePage_bytes;
  void* const mapped =
      ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) return nullptr;
  const auto begin = reinterpret_cast<std::uintptr_t>(mapped);
  const std::size_t before = (kHugePage_bytes - begin % kHugePage_bytes) % kHugePage_bytes;
  auto* const memory = static_cast<std::byte*>(mapped) + before;
  if (before > 0) (void)::munmap(mapped, before);
  (void)::munmap(memory + size, room - before - size);
  (void)::madvise(memory, size / kHugePage_bytes * kHugePage_bytes, MADV_HUGEPAGE);  // advice
  return memory;
}
inline void unmap_pages(void* memory, std::size_t size) { (void)::munmap(memory, size); }

// Memory of std::allocator; that of a long array is the system's again once it is freed. A program
// that makes such arrays again and again, of several sizes, keeps much of it otherwise.
template <class T>
struct MappedAllocator {
  using value_type = T;

  MappedAllocator() = default;
  template <class Other>
  explicit(false) MappedAllocator(const MappedAllocator<Other>&) {}

  T* allocate(std::size_t count) {
    if (!is_long(count)) return std::allocator<T>().allocate(count);
    void* const memory = map_pages(size_of(count));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (!is_long(count)) return std::allocator<T>().deallocate(memory, count);
    unmap_pages(memory, size_of(count));
  }
  friend bool operator==(const MappedAllocator&, const MappedAllocator&) { return true; }

 private:
  static constexpr std::size_t kPage_bytes = std::size_t{64} << 10;  // of any machine, a multiple

  static std::size_t size_of(std::size_t count) {
    return (count * sizeof(T) + kPage_bytes - 1) / kPage_bytes * kPage_bytes;
  }
  // From half a large page on; more than any memory holds is left to the other allocator's error.
  static bool is_long(std::size_t count) {
    return count >= kHugePage_bytes / 2 / sizeof(T) && count < (std::size_t{1} << 46) / sizeof(T);
  }
};

template <class T>
using MappedVector = std::vector<T, MappedAllocator<T>>;

}  // namespace sightline
