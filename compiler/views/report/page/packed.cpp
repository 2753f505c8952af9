#include "compiler/views/report/page/packed.h"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "formats/base/check.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

std::vector<std::byte> by_planes(std::span<const std::byte> bytes, std::size_t element_size) {
  const std::size_t count = bytes.size() / element_size;
  std::vector<std::byte> planes(bytes.size());
  for (std::size_t plane = 0; plane < element_size; ++plane) {
    for (std::size_t i = 0; i < count; ++i) {
      planes[plane * count + i] = bytes[i * element_size + plane];
    }
  }
  return planes;
}

}  // namespace

std::string packed(std::span<const std::byte> bytes, std::size_t element_size) {
  const std::vector<std::byte> planes = by_planes(bytes, element_size);
  uLongf size = compressBound(static_cast<uLong>(planes.size()));
  std::vector<std::byte> stream(size);
  const int status = compress2(reinterpret_cast<Bytef*>(stream.data()), &size,
                               reinterpret_cast<const Bytef*>(planes.data()),
                               static_cast<uLong>(planes.size()), Z_BEST_COMPRESSION);
  SIGHTLINE_CHECK(status == Z_OK);
  stream.resize(size);
  return base64_of(stream);
}

float four_digits(double value) {
  constexpr std::uint32_t kDropped = (1U << 10U) - 1U;  // of 23 bits: 1 in 16384 is left
  const auto number = static_cast<float>(value);
  if (!std::isfinite(number)) return number;
  // Half a unit of what is kept is added, so that it rounds; a carry goes on into the exponent.
  const auto bits = std::bit_cast<std::uint32_t>(number);
  return std::bit_cast<float>((bits + kDropped / 2U + 1U) & ~kDropped);
}

}  // namespace sightline
