#include "formats/map/container/byte_planes.h"

#include "formats/base/check.h"

namespace sightline {
namespace {

std::uint64_t number_at(const std::byte* bytes, std::uint32_t width) {
  std::uint64_t value = 0;
  for (std::uint32_t i = 0; i < width; ++i) {
    value |= std::uint64_t{std::to_integer<std::uint8_t>(bytes[i])} << (8 * i);
  }
  return value;
}

std::byte byte_of(std::uint64_t value, std::uint32_t i) {
  return static_cast<std::byte>(value >> (8 * i) & 0xFFU);
}

}  // namespace

void append_planes(std::span<const std::byte> array, const ArrayShape& shape,
                   std::vector<std::byte>& planes) {
  SIGHTLINE_CHECK(array.size() == shape.size());
  const std::size_t begin = planes.size();
  planes.resize(begin + array.size());
  const std::uint64_t stride = std::uint64_t{shape.per_row} * shape.width;
  for (std::uint32_t number = 0; number < shape.per_row; ++number) {
    std::byte* out = planes.data() + begin + std::uint64_t{number} * shape.width * shape.rows;
    const std::byte* in = array.data() + std::uint64_t{number} * shape.width;
    std::uint64_t before = 0;
    for (std::uint64_t row = 0; row < shape.rows; ++row) {
      const std::uint64_t value = number_at(in + row * stride, shape.width);
      for (std::uint32_t i = 0; i < shape.width; ++i) {
        out[i * shape.rows + row] = byte_of(value - before, i);
      }
      before = value;
    }
  }
}

void from_planes(std::span<const std::byte> planes, const ArrayShape& shape,
                 std::span<std::byte> array) {
  SIGHTLINE_CHECK(planes.size() == shape.size() && array.size() == shape.size());
  const std::uint64_t stride = std::uint64_t{shape.per_row} * shape.width;
  for (std::uint32_t number = 0; number < shape.per_row; ++number) {
    const std::byte* in = planes.data() + std::uint64_t{number} * shape.width * shape.rows;
    std::byte* out = array.data() + std::uint64_t{number} * shape.width;
    std::uint64_t value = 0;
    for (std::uint64_t row = 0; row < shape.rows; ++row) {
      std::uint64_t difference = 0;
      for (std::uint32_t i = 0; i < shape.width; ++i) {
        difference |= std::uint64_t{std::to_integer<std::uint8_t>(in[i * shape.rows + row])}
                      << (8 * i);
      }
      value += difference;
      for (std::uint32_t i = 0; i < shape.width; ++i) out[row * stride + i] = byte_of(value, i);
    }
  }
}

}  // namespace sightline
