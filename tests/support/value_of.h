#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

#include "formats/base/result.h"

// Results in tests. Each ends the test, with the place of the call, where it finds the other kind;
// `about` is added to the message, for calls in a loop.
// Clang 14 has no std::source_location with the library of GCC 12: builtins of both take its place.

namespace sightline {

template <class About>
[[noreturn]] void end_test(const std::string& why, const About& about, const char* file, int line) {
  std::ostringstream text;
  text << file << ":" << line << ": " << why << " " << about;
  throw std::runtime_error(text.str());
}

template <class X, class About = const char*>
X value_of(Result<X> result, const About& about = "", const char* file = __builtin_FILE(),
           int line = __builtin_LINE()) {
  if (!result) end_test(to_string(result.error()), about, file, line);
  return *std::move(result);
}

template <class X, class About = const char*>
void require(const Result<X>& result, const About& about = "", const char* file = __builtin_FILE(),
             int line = __builtin_LINE()) {
  if (!result) end_test(to_string(result.error()), about, file, line);
}

template <class X, class About = const char*>
Error failure_of(const Result<X>& result, const About& about = "",
                 const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (result) end_test("the call succeeded, a failure was expected", about, file, line);
  return result.error();
}

// "no error", or code and message.
template <class X>
std::string outcome_of(const Result<X>& result) {
  return result ? "no error" : to_string(result.error());
}

// The error code of a call, 0 where it succeeds.
template <class X>
ErrorCode code_of(const Result<X>& result) {
  return result ? ErrorCode{} : result.error().code;
}

}  // namespace sightline
