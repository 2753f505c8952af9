#pragma once

#include <optional>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/error.h"

namespace sightline {

// A value or an Error, in the words of std::expected (which GCC 12 does not have in C++20).
// Looking at the wrong one stops the program.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}      // NOLINT: implicit
  Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit

  [[nodiscard]] bool has_value() const { return value_.has_value(); }
  explicit operator bool() const { return has_value(); }

  T& value() & { return checked(); }
  const T& value() const& { return const_cast<Result*>(this)->checked(); }
  T&& value() && { return std::move(checked()); }
  T& operator*() & { return checked(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(checked()); }
  T* operator->() { return &checked(); }
  const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const {
    SIGHTLINE_CHECK(!has_value());
    return error_;
  }

 private:
  T& checked() {
    SIGHTLINE_CHECK(has_value());
    return *value_;
  }
  // Not a std::variant: files with many Results would take 7 to 11 % longer to compile.
  std::optional<T> value_;
  Error error_;  // where there is no value
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit

  [[nodiscard]] bool has_value() const { return !error_.has_value(); }
  explicit operator bool() const { return has_value(); }
  [[nodiscard]] const Error& error() const {
    SIGHTLINE_CHECK(error_.has_value());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace sightline

// Passes an error on: ends the function (which returns an Error or a Result of anything) with the
// error of an expression that is one, and goes on otherwise.
//
//   SIGHTLINE_TRY(write_header(out));
//   SIGHTLINE_ASSIGN(const Header header, read_header(in));
//   SIGHTLINE_ASSIGN(body, read_body(in, header));
//
// SIGHTLINE_ASSIGN goes on with the value, moved into what its first argument declares or names; a
// type with a comma in it needs an alias there. Each evaluates its expression once, and neither may
// stand within the expression of another.
#define SIGHTLINE_TRY(...) \
  SIGHTLINE_TRY_AS(SIGHTLINE_JOIN(sightline_result_, __LINE__), (__VA_ARGS__))
#define SIGHTLINE_ASSIGN(target, ...) \
  SIGHTLINE_ASSIGN_AS(SIGHTLINE_JOIN(sightline_result_, __LINE__), target, (__VA_ARGS__))

// What they are made of.
#define SIGHTLINE_JOIN_NOW(a, b) a##b
#define SIGHTLINE_JOIN(a, b) SIGHTLINE_JOIN_NOW(a, b)
#define SIGHTLINE_TRY_AS(result, expression)                             \
  do {                                                                   \
    if (const auto& result = expression; !result) return result.error(); \
  } while (false)
#define SIGHTLINE_ASSIGN_AS(result, target, expression) \
  auto result = expression;                             \
  if (!result) return result.error();                   \
  target = *std::move(result)
