#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

#include "formats/foreign/ros/files/message_log.h"

namespace sightline {

struct MessageHeader {
  std::int64_t stamp_ns = 0;
  std::string frame;  // without a leading slash
};

// Reads the fields of a message in turn. CDR (XCDR1, and XCDR2 of types that are final, as those of
// ROS 2 are): each number stands at a multiple of its size behind the 4 bytes that name the byte
// order. Reads stop at the first failure: from there on each gives zero and ok() is false.
class MessageReader {
 public:
  MessageReader(std::span<const std::byte> message, MessageEncoding encoding);

  template <class T>
  requires std::is_arithmetic_v<T> T get() {
    align(sizeof(T));
    std::array<std::byte, sizeof(T)> raw{};
    const std::span<const std::byte> bytes = take(raw.size());
    if (!ok_) return T{};
    std::ranges::copy(bytes, raw.begin());
    if (is_swapped_) std::ranges::reverse(raw);
    T value{};
    std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }
  std::string text();
  // The length of a sequence of elements of at least `element_size` bytes, which must remain.
  std::uint32_t count(std::size_t element_size);
  // The next bytes as they lie.
  std::span<const std::byte> take(std::size_t size);
  // A time: seconds and nanoseconds.
  std::int64_t time_ns();
  // std_msgs/Header.
  MessageHeader header();

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }

 private:
  void align(std::size_t size);

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  std::size_t origin_ = 0;  // alignment counts from here
  std::size_t widest_alignment_ = 1;
  bool is_cdr_ = false;
  bool is_swapped_ = false;
  bool ok_ = true;
};

}  // namespace sightline
