#include "tests/fuzz/fuzz.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace sightline {

FuzzInput::FuzzInput(const std::uint8_t* data, std::size_t size)
    : bytes_(static_cast<std::byte*>(std::malloc(std::max<std::size_t>(size, 1)))), size_(size) {
  SIGHTLINE_CHECK(bytes_ != nullptr);
  if (size > 0) std::memcpy(bytes_, data, size);
}

FuzzInput::~FuzzInput() { std::free(bytes_); }

void mutate_in_place(std::span<std::byte> part) {
  if (part.empty()) return;
  LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(part.data()), part.size(), part.size());
}

std::size_t hand_back(std::span<const std::byte> mutated, std::uint8_t* data, std::size_t size,
                      std::size_t max_size) {
  if (mutated.size() > max_size) return size;
  if (!mutated.empty()) std::memcpy(data, mutated.data(), mutated.size());
  return mutated.size();
}

}  // namespace sightline
