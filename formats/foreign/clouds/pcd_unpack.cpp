#include "formats/foreign/clouds/pcd_unpack.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

namespace sightline {
namespace {

// Numbers of one type are read without asking again for each point which type that is.
template <class T>
struct TypedColumn {
  explicit TypedColumn(const FieldColumn& column) : next(column.first), stride(column.stride) {}
  T take() {
    T value;
    std::memcpy(&value, next, sizeof value);
    next += stride;
    return value;
  }
  const std::uint8_t* next;
  std::size_t stride;
};

struct AnyColumn {
  explicit AnyColumn(const FieldColumn& column) : rest(column) {}
  double take() {
    const double value = read_element(rest.first, rest.type);
    rest.first += rest.stride;
    return value;
  }
  FieldColumn rest;
};

struct NoColumn {
  static float take() { return 0.0F; }
};

bool is_of(const FieldColumn& column, std::size_t float_size) {
  return column.type.kind == ElementKind::kFloat && column.type.size == float_size;
}

// Negative where x, y, z may be no return: one is NaN or infinite, or x is zero. Numbers without
// their sign compare as their bits do, so this needs no branch and no flags.
template <class Number>
auto doubts_about(Number x, Number y, Number z) {
  using Bits = std::conditional_t<sizeof(Number) == 4, std::int32_t, std::int64_t>;
  constexpr Bits kMagnitude = std::numeric_limits<Bits>::max();
  const Bits largest = std::bit_cast<Bits>(std::numeric_limits<Number>::max());
  const Bits x_bits = std::bit_cast<Bits>(x) & kMagnitude;
  const Bits y_bits = std::bit_cast<Bits>(y) & kMagnitude;
  const Bits z_bits = std::bit_cast<Bits>(z) & kMagnitude;
  return (largest - x_bits) | (largest - y_bits) | (largest - z_bits) | (x_bits - 1);
}

// The columns from some point on, and what was kept of the points before.
template <class Position, class Intensity>
struct PointReader {
  std::array<Position, 3> position;
  Intensity intensity;
  std::size_t kept = 0;

  // Keeps the next points as if all were returns. False where that is in doubt: then nothing of
  // this reader may be used.
  bool take_all(std::size_t count, PointCloudFile& cloud) {
    Eigen::Vector3d* points_m = cloud.points_m.data() + kept;
    float* intensities = cloud.intensity.data() + kept;
    decltype(doubts_about(position[0].take(), position[0].take(), position[0].take())) doubts = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const auto x = position[0].take();
      const auto y = position[1].take();
      const auto z = position[2].take();
      doubts |= doubts_about(x, y, z);
      points_m[i] = Eigen::Vector3d(x, y, z);
      intensities[i] = static_cast<float>(intensity.take());
    }
    kept += count;
    return doubts >= 0;
  }

  // Writes each point where the next return belongs, which it may be or not.
  void take_returns(std::size_t count, PointCloudFile& cloud) {
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d point_m(position[0].take(), position[1].take(), position[2].take());
      const bool is_finite = point_m.allFinite();
      const bool is_zero = point_m.isZero(0.0);
      cloud.points_m[kept] = point_m;
      cloud.intensity[kept] = static_cast<float>(intensity.take());
      cloud.nonfinite_count += is_finite ? 0 : 1;
      cloud.zero_count += is_zero ? 1 : 0;
      kept += is_finite && !is_zero ? 1 : 0;
    }
  }
};

template <class Position, class Intensity>
void keep_returns(std::size_t count, PointReader<Position, Intensity> reader,
                  PointCloudFile& cloud) {
  constexpr std::size_t kBlock = 256;  // points that are looked at again for one that is no return
  cloud.points_m.resize(count);
  cloud.intensity.resize(count);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t block = std::min(kBlock, count - begin);
    PointReader<Position, Intensity> hopeful = reader;
    if (hopeful.take_all(block, cloud)) {
      reader = hopeful;
    } else {
      reader.take_returns(block, cloud);
    }
  }
  cloud.points_m.resize(reader.kept);
  cloud.intensity.resize(reader.kept);
}

template <class Position>
void read_typed(const PointColumns& columns, PointCloudFile& cloud) {
  const std::array<Position, 3> position = {
      Position(columns.position[0]), Position(columns.position[1]), Position(columns.position[2])};
  const std::size_t count = columns.count;
  if (!columns.intensity) {
    keep_returns(count, PointReader<Position, NoColumn>{position, {}}, cloud);
  } else if (is_of(*columns.intensity, sizeof(float))) {
    using Floats = TypedColumn<float>;
    keep_returns(count, PointReader<Position, Floats>{position, Floats(*columns.intensity)}, cloud);
  } else {
    const AnyColumn intensity(*columns.intensity);
    keep_returns(count, PointReader<Position, AnyColumn>{position, intensity}, cloud);
  }
}

// The two sorts of instruction of an LZF stream; each gives false where it reaches out of either
// side.
struct LzfReader {
  const std::uint8_t* in;
  const std::uint8_t* in_end;
  std::uint8_t* out_begin;
  std::uint8_t* out;
  std::uint8_t* out_end;

  bool copy_literals(std::size_t count) {
    if (static_cast<std::size_t>(in_end - in) < count) return false;
    if (static_cast<std::size_t>(out_end - out) < count) return false;
    std::memcpy(out, in, count);
    in += count;
    out += count;
    return true;
  }

  // `control` is LLLddddd: a length less two, where 7 means that another byte adds to it, and the
  // high bits of a distance back less one.
  bool repeat(std::uint8_t control) {
    std::size_t count = control >> 5U;
    if (count == 7) {
      if (in == in_end) return false;
      count += *in++;
    }
    count += 2;
    if (in == in_end) return false;
    const std::size_t back = ((control & 0x1fU) << 8U) + *in++ + 1U;
    if (static_cast<std::size_t>(out - out_begin) < back) return false;
    if (static_cast<std::size_t>(out_end - out) < count) return false;
    const std::uint8_t* from = out - back;
    if (back >= count) {
      std::memcpy(out, from, count);
    } else {
      // What is repeated may still be in the making: byte by byte.
      for (std::size_t i = 0; i < count; ++i) out[i] = from[i];
    }
    out += count;
    return true;
  }
};

double number_at(const FieldColumn& column, std::size_t index) {
  return read_element(column.first + index * column.stride, column.type);
}

// Of the points that add_point() keeps. In a second walk, since most files have no times.
std::vector<double> times_of_returns(const PointColumns& columns) {
  std::vector<double> times;
  for (std::size_t i = 0; i < columns.count; ++i) {
    const Eigen::Vector3d point_m(number_at(columns.position[0], i),
                                  number_at(columns.position[1], i),
                                  number_at(columns.position[2], i));
    if (point_m.allFinite() && !point_m.isZero(0.0)) times.push_back(number_at(*columns.time, i));
  }
  return times;
}

}  // namespace

bool unpack_lzf(std::span<const std::uint8_t> packed, std::span<std::uint8_t> unpacked) {
  constexpr std::uint8_t kLiterals = 32;  // control bytes below this: so many literals less one
  LzfReader reader{packed.data(), packed.data() + packed.size(), unpacked.data(), unpacked.data(),
                   unpacked.data() + unpacked.size()};
  while (reader.in != reader.in_end) {
    const std::uint8_t control = *reader.in++;
    const bool is_sound = control < kLiterals ? reader.copy_literals(control + std::size_t{1})
                                              : reader.repeat(control);
    if (!is_sound) return false;
  }
  return reader.out == reader.out_end;
}

PointCloudFile read_points(const PointColumns& columns) {
  const auto all_of_size = [&](std::size_t float_size) {
    return std::ranges::all_of(
        columns.position, [&](const FieldColumn& column) { return is_of(column, float_size); });
  };
  PointCloudFile cloud;
  if (all_of_size(sizeof(float))) {
    read_typed<TypedColumn<float>>(columns, cloud);
  } else if (all_of_size(sizeof(double))) {
    read_typed<TypedColumn<double>>(columns, cloud);
  } else {
    read_typed<AnyColumn>(columns, cloud);
  }
  columns.time_name.set_times(columns.time ? times_of_returns(columns) : std::vector<double>(),
                              cloud);
  return cloud;
}

}  // namespace sightline
