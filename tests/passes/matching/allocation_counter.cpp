#include "tests/passes/matching/allocation_counter.h"

#include <atomic>
#include <cstdlib>
#include <new>

// In a file of its own, or the compiler sees through the replacement and warns of a mismatch.

namespace {
std::atomic<std::size_t> count = 0;
}  // namespace

void* operator new(std::size_t size) {
  ++count;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// What asks without an exception frees by the same operator.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace sightline {
std::size_t allocation_count() { return count; }
}  // namespace sightline
