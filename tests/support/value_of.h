#pragma once

#include <source_location>
#include <sstream>
#include <stdexcept>

#include "formats/base/result.h"

// Results in tests. Each ends the test, with the place of the call, where it finds the other kind;
// `about` is added to the message, for calls in a loop.

namespace sightline {

template <class About>
[[noreturn]] void end_test(const std::string& why, const About& about,
                           const std::source_location& where) {
  std::ostringstream text;
  text << where.file_name() << ":" << where.line() << ": " << why << " " << about;
  throw std::runtime_error(text.str());
}

// The value of a call that must succeed.
template <class X, class About = const char*>
X value_of(Result<X> result, const About& about = "",
           const std::source_location& where = std::source_location::current()) {
  if (!result) end_test(to_string(result.error()), about, where);
  return *std::move(result);
}

template <class X, class About = const char*>
void require(const Result<X>& result, const About& about = "",
             const std::source_location& where = std::source_location::current()) {
  if (!result) end_test(to_string(result.error()), about, where);
}

// The error of a call that must fail.
template <class X, class About = const char*>
Error failure_of(const Result<X>& result, const About& about = "",
                 const std::source_location& where = std::source_location::current()) {
  if (result) end_test("the call succeeded, a failure was expected", about, where);
  return result.error();
}

}  // namespace sightline
