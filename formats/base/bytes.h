#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

// Little-endian bytes, written and read field by field. A reader never trusts a length: every
// count is checked against what remains before anything is allocated.

namespace sightline {

// Takes bytes that come in pieces, in their order.
using ByteSink = std::function<Result<void>(std::span<const std::byte>)>;

static_assert(std::endian::native == std::endian::little,
              "sightline runs on little-endian machines");

class ByteWriter {
 public:
  ByteWriter() = default;
  // One that keeps no byte and only counts them.
  static ByteWriter that_counts() {
    ByteWriter writer;
    writer.only_counts_ = true;
    return writer;
  }
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void put(T value) { append(&value, sizeof value); }
  void put_string(std::string_view text) {
    put<std::uint64_t>(text.size());
    append(text.data(), text.size());
  }
  // Count, then the elements as they lie. For plain fixed-width types without padding only.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put_array(std::span<const T> values) {
    put<std::uint64_t>(values.size());
    append(values.data(), values.size_bytes());
  }
  template <class T>
  void put_array(const std::vector<T>& values) {
    put_array(std::span<const T>(values));
  }
  void append(const void* data, std::size_t size) {
    if (size == 0) return;
    count_ += size;
    if (only_counts_) return;
    const std::size_t offset = bytes_.size();
    if (bytes_.capacity() < offset + size) bytes_.reserve(2 * (offset + size));
    bytes_.resize(offset + size);
    std::memcpy(bytes_.data() + offset, data, size);
  }
  // Takes memory for so many bytes in all, so that what was written is never moved.
  void reserve(std::size_t size) { bytes_.reserve(size); }
  // Of what was written.
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t count_ = 0;
  bool only_counts_ = false;
};

// Reads stop at the first failure: after it every get() leaves its argument alone and ok() is
// false, so a decoder may read a whole struct and ask once.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void get(T& value) {
    if (!need(sizeof value)) return;
    std::memcpy(&value, bytes_.data() + offset_, sizeof value);
    offset_ += sizeof value;
  }
  template <class T>
  T get() {
    T value{};
    get(value);
    return value;
  }
  void get_string(std::string& text) {
    const std::size_t size = get_count(1);
    if (!ok_) return;
    text.assign(reinterpret_cast<const char*>(bytes_.data() + offset_), size);
    offset_ += size;
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get_array(std::vector<T>& values) {
    const std::size_t count = get_count(sizeof(T));
    if (!ok_) return;
    values.resize(count);
    if (count > 0) {
      std::memcpy(static_cast<void*>(values.data()), bytes_.data() + offset_, count * sizeof(T));
    }
    offset_ += count * sizeof(T);
  }
  // A count of elements of at least `element_size` bytes each, checked against what remains.
  std::size_t get_count(std::size_t element_size) {
    const auto count = get<std::uint64_t>();
    if (ok_ && count > remaining() / element_size) ok_ = false;
    return ok_ ? static_cast<std::size_t>(count) : 0;
  }
  void fail() { ok_ = false; }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return ok_ && offset_ == bytes_.size(); }
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }

 private:
  bool need(std::size_t size) {
    if (ok_ && remaining() < size) ok_ = false;
    return ok_;
  }
  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
  bool ok_ = true;
};

}  // namespace sightline
