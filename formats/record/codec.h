#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/record/fields.h"

// Bytes of a struct that lists its fields (record/fields.h): field after field, without padding.
// Numbers and enums little-endian; a bool is a byte, 0 or 1; an optional a byte, 1 where its value
// follows; a string or vector its count as 64 bits and what it holds; arrays, pairs and matrices
// their elements (matrices by column). A type without fields has encode and decode of its own.

namespace sightline {

// An Eigen matrix or vector of fixed size.
template <class T>
concept FixedMatrix = requires(T& matrix) {
  { matrix.data() } -> std::same_as<typename T::Scalar*>;
  requires sizeof(T) == sizeof(typename T::Scalar) * std::size_t{T::SizeAtCompileTime};
};

template <class T>
concept PlainNumber = std::is_arithmetic_v<T> && !std::same_as<T, bool>;

class FieldWriter {
 public:
  explicit FieldWriter(ByteWriter& writer) : writer_(writer) {}

  template <class T>
  void operator()(std::string_view /*name*/, const T& field) {
    put(field);
  }

  template <class T>
  void put(const T& value) {
    encode(value, writer_);
  }
  template <HasFields T>
  void put(const T& record) {
    fields(*this, record);
  }
  template <PlainNumber T>
  void put(const T& number) {
    writer_.put(number);
  }
  template <NamedEnum T>
  void put(const T& value) {
    writer_.put(value);
  }
  void put(const bool& value) { writer_.put<std::uint8_t>(value ? 1 : 0); }
  void put(const std::string& text) { writer_.put_string(text); }
  template <FixedMatrix T>
  void put(const T& matrix) {
    writer_.append(matrix.data(), sizeof matrix);
  }
  template <class T, std::size_t kSize>
  void put(const std::array<T, kSize>& values) {
    for (const T& value : values) put(value);
  }
  template <class A, class B>
  void put(const std::pair<A, B>& both) {
    put(both.first);
    put(both.second);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    writer_.put<std::uint64_t>(values.size());
    if constexpr (PlainNumber<T> || FixedMatrix<T>) {
      writer_.append(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) put(value);
    }
  }

 private:
  ByteWriter& writer_;
};

// Fails the reader at a bool that is neither 0 nor 1, a value that its enum does not name, and a
// count that what remains cannot hold. Memory stays within a multiple of what was read.
class FieldReader {
 public:
  explicit FieldReader(ByteReader& reader) : reader_(reader) {}

  template <class T>
  void operator()(std::string_view /*name*/, T& field) {
    get(field);
  }

  template <class T>
  void get(T& value) {
    decode(reader_, value);
  }
  template <HasFields T>
  void get(T& record) {
    // A record may hold others of its kind: damaged bytes must not exhaust the stack.
    constexpr int kDeepest = 16;
    if (depth_ == kDeepest) return reader_.fail();
    ++depth_;
    fields(*this, record);
    --depth_;
  }
  template <PlainNumber T>
  void get(T& number) {
    reader_.get(number);
  }
  template <NamedEnum T>
  void get(T& value) {
    reader_.get(value);
    if (name_of(value).empty()) reader_.fail();
  }
  void get(bool& value) {
    const auto byte = reader_.get<std::uint8_t>();
    if (byte > 1) reader_.fail();
    value = byte == 1;
  }
  void get(std::string& text) { reader_.get_string(text); }
  template <FixedMatrix T>
  void get(T& matrix) {
    for (std::size_t i = 0; i < T::SizeAtCompileTime; ++i) reader_.get(matrix.data()[i]);
  }
  template <class T, std::size_t kSize>
  void get(std::array<T, kSize>& values) {
    for (T& value : values) get(value);
  }
  template <class A, class B>
  void get(std::pair<A, B>& both) {
    get(both.first);
    get(both.second);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool has_value = false;
    get(has_value);
    value.reset();
    if (has_value) get(value.emplace());
  }
  template <class T>
  void get(std::vector<T>& values) {
    if constexpr (PlainNumber<T>) {
      reader_.get_array(values);
    } else if constexpr (FixedMatrix<T>) {
      values.resize(reader_.get_count(sizeof(T)));
      for (T& value : values) get(value);
    } else {
      // One by one: a count that is wrong fails before it takes memory.
      values.clear();
      const std::size_t count = reader_.get_count(1);
      values.reserve(std::min(count, reader_.remaining() / sizeof(T)));
      while (values.size() < count && reader_.ok()) get(values.emplace_back());
    }
  }

 private:
  ByteReader& reader_;
  int depth_ = 0;
};

// These values one after another.
template <class... Values>
ByteWriter written(const Values&... values) {
  ByteWriter writer;
  FieldWriter put(writer);
  (put.put(values), ...);
  return writer;
}

template <HasFields X>
void encode(const X& record, ByteWriter& writer) {
  FieldWriter(writer).put(record);
}
template <HasFields X>
void encode(const std::vector<X>& records, ByteWriter& writer) {
  FieldWriter(writer).put(records);
}

template <HasFields X>
void decode(ByteReader& reader, X& record) {
  FieldReader(reader).get(record);
}
template <HasFields X>
void decode(ByteReader& reader, std::vector<X>& records) {
  FieldReader(reader).get(records);
}

}  // namespace sightline
