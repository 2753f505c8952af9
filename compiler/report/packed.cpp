#include "compiler/report/packed.h"

#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>

#include "compiler/base/check.h"

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

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t triple = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      triple = triple << 8U | (k < left ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= left ? kDigits[triple >> (18U - 6U * k) & 63U] : '=';
    }
  }
  return text;
}

std::string packed(std::span<const std::byte> bytes, std::size_t element_size) {
  const std::vector<std::byte> planes = by_planes(bytes, element_size);
  uLongf size = compressBound(static_cast<uLong>(planes.size()));
  std::vector<std::byte> stream(size);
  const int status = compress2(reinterpret_cast<Bytef*>(stream.data()), &size,
                               reinterpret_cast<const Bytef*>(planes.data()),
                               static_cast<uLong>(planes.size()), Z_BEST_COMPRESSION);
  SIGHTLINE_CHECK(status == Z_OK);
  stream.resize(size);
  return base64(stream);
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
