#pragma once

#include <zstd_errors.h>

#include <cstddef>
#include <new>

// zstd reports missing memory by an error code or a null context. Here it is std::bad_alloc, as of
// every other allocation, so that it is not taken for damage of a file.

namespace sightline {

inline std::size_t with_memory(std::size_t zstd_result) {
  if (ZSTD_getErrorCode(zstd_result) == ZSTD_error_memory_allocation) throw std::bad_alloc();
  return zstd_result;
}

template <class Context>
Context* with_memory(Context* made) {
  if (made == nullptr) throw std::bad_alloc();
  return made;
}

}  // namespace sightline
