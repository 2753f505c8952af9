#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "formats/base/check.h"
#include "formats/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed);

namespace sightline {

// The input in a buffer of exactly its size, so that AddressSanitizer sees a read past its end, at
// an address that is a multiple of 8, as a mapped file has it.
class FuzzInput {
 public:
  FuzzInput(const std::uint8_t* data, std::size_t size);
  ~FuzzInput();
  FuzzInput(const FuzzInput&) = delete;
  FuzzInput& operator=(const FuzzInput&) = delete;
  [[nodiscard]] std::span<const std::byte> bytes() const { return {bytes_, size_}; }

 private:
  std::byte* bytes_;
  std::size_t size_;
};

// A refusal is of the input, or one of these, and says something.
inline void check_refusal(const Error& error, std::initializer_list<ErrorCode> also = {},
                          bool may_be_usage = false) {
  const ErrorClass kind = error_class(error.code);
  SIGHTLINE_CHECK(kind == ErrorClass::kInput || (may_be_usage && kind == ErrorClass::kUsage) ||
                  std::find(also.begin(), also.end(), error.code) != also.end());
  SIGHTLINE_CHECK(!error.message.empty());
}

// Mutates a part of the input in place and leaves its size, so that all else stays where it is.
void mutate_in_place(std::span<std::byte> part);

// Copies a mutated input to where libFuzzer wants it; the old one stays where the new one does not
// fit. Returns the size.
std::size_t hand_back(std::span<const std::byte> mutated, std::uint8_t* data, std::size_t size,
                      std::size_t max_size);

}  // namespace sightline
