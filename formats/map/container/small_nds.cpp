#include "formats/map/container/small_nds.h"

#include <algorithm>
#include <cstring>

#include "formats/map/container/byte_planes.h"
#include "formats/map/container/zstd_frame.h"

// Packed: half the step of means (i32), differences of the three columns of keys as planes, then
// the eleven numbers of each ND, all rows of one after all rows of another; in one frame.

namespace sightline {
namespace {

constexpr std::size_t kKeyColumns = 3;
constexpr std::size_t kNumbers = 11;
constexpr std::uint64_t kBytesPerRow = kKeyColumns * sizeof(std::int32_t) + kNumbers;

template <class T>
T load(std::span<const std::byte> bytes, std::uint64_t column, std::uint64_t i) {
  T value;
  std::memcpy(&value, bytes.data() + column + i * sizeof(T), sizeof value);
  return value;
}

template <class T>
void store(std::vector<std::byte>& bytes, std::uint64_t column, std::uint64_t i, T value) {
  std::memcpy(bytes.data() + column + i * sizeof(T), &value, sizeof value);
}

using Numbers = std::array<std::uint8_t, kNumbers>;

Numbers numbers_of(const SmallNd& nd) {
  const auto bits = [](std::int8_t value) { return static_cast<std::uint8_t>(value); };
  return {nd.count,          nd.mean[0],        nd.mean[1],        nd.mean[2],
          nd.order,          bits(nd.scale[0]), bits(nd.scale[1]), bits(nd.scale[2]),
          bits(nd.slope[0]), bits(nd.slope[1]), bits(nd.slope[2])};
}

SmallNd small_of(const Numbers& numbers) {
  const auto signed_of = [&](std::size_t i) { return static_cast<std::int8_t>(numbers[i]); };
  return {numbers[0],
          {numbers[1], numbers[2], numbers[3]},
          numbers[4],
          {signed_of(5), signed_of(6), signed_of(7)},
          {signed_of(8), signed_of(9), signed_of(10)}};
}

}  // namespace

NdRow load_nd_row(std::span<const std::byte> raw, const NdtLayout& layout, std::uint64_t row) {
  NdRow nd;
  nd.point_count = load<std::uint32_t>(raw, layout.column[3], row);
  for (std::size_t i = 0; i < nd.mean_units.size(); ++i) {
    nd.mean_units[i] = load<std::int32_t>(raw, layout.column[4 + i], row);
  }
  for (std::size_t i = 0; i < nd.covariance_m2.size(); ++i) {
    nd.covariance_m2[i] = load<float>(raw, layout.column[7 + i], row);
  }
  return nd;
}

void store_nd_row(const NdRow& nd, const NdtLayout& layout, std::uint64_t row,
                  std::vector<std::byte>& raw) {
  store(raw, layout.column[3], row, nd.point_count);
  for (std::size_t i = 0; i < nd.mean_units.size(); ++i) {
    store(raw, layout.column[4 + i], row, nd.mean_units[i]);
  }
  for (std::size_t i = 0; i < nd.covariance_m2.size(); ++i) {
    store(raw, layout.column[7 + i], row, nd.covariance_m2[i]);
  }
}

std::optional<std::vector<std::byte>> pack_small_nds(std::span<const std::byte> raw,
                                                     std::uint64_t row_count, double cell_m) {
  const NdtLayout layout(row_count);
  const std::int32_t half_step = half_step_units(cell_m);
  std::vector<std::byte> planes(sizeof half_step);
  std::memcpy(planes.data(), &half_step, sizeof half_step);
  for (std::size_t column = 0; column < kKeyColumns; ++column) {
    const ArrayShape keys{row_count, 1, sizeof(std::int32_t)};
    append_planes(raw.subspan(layout.column[column], keys.size()), keys, planes);
  }
  const std::size_t begin = planes.size();
  planes.resize(begin + kNumbers * row_count);
  for (std::uint64_t row = 0; row < row_count; ++row) {
    const std::optional<SmallNd> small = small_of(load_nd_row(raw, layout, row), half_step);
    if (!small) return std::nullopt;
    const Numbers numbers = numbers_of(*small);
    for (std::size_t i = 0; i < kNumbers; ++i) {
      planes[begin + i * row_count + row] = static_cast<std::byte>(numbers[i]);
    }
  }
  return zstd_frame(planes);
}

Result<std::vector<std::byte>> unpack_small_nds(std::span<const std::byte> stored,
                                                std::uint64_t row_count, std::uint64_t raw_size) {
  const NdtLayout layout(row_count);
  std::int32_t half_step = 0;
  const std::uint64_t packed_size = sizeof half_step + kBytesPerRow * row_count;
  if (raw_size != layout.size) return unreadable_block();
  SIGHTLINE_ASSIGN(const std::vector<std::byte> planes, bytes_of_frame(stored, packed_size));
  if (planes.size() != packed_size) return unreadable_block();
  std::memcpy(&half_step, planes.data(), sizeof half_step);
  if (half_step < 1 || half_step > half_step_units(1e9)) return unreadable_block();
  std::vector<std::byte> raw(layout.size);
  std::size_t place = sizeof half_step;
  for (std::size_t column = 0; column < kKeyColumns; ++column) {
    const ArrayShape keys{row_count, 1, sizeof(std::int32_t)};
    from_planes(std::span(planes).subspan(place, keys.size()), keys,
                std::span(raw).subspan(layout.column[column], keys.size()));
    place += keys.size();
  }
  for (std::uint64_t row = 0; row < row_count; ++row) {
    Numbers numbers;
    for (std::size_t i = 0; i < kNumbers; ++i) {
      numbers[i] = std::to_integer<std::uint8_t>(planes[place + i * row_count + row]);
    }
    store_nd_row(expanded(small_of(numbers), half_step), layout, row, raw);
  }
  return raw;
}

}  // namespace sightline
