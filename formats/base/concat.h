#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

namespace sightline {

// A part of a text: a text, a character or a whole number, which is written in decimal. Refers to
// the text.
class TextPart {
 public:
  TextPart(std::string_view text) : text_(text) {}    // NOLINT(google-explicit-constructor)
  TextPart(const std::string& text) : text_(text) {}  // NOLINT(google-explicit-constructor)
  TextPart(const char* text) : text_(text) {}         // NOLINT(google-explicit-constructor)
  TextPart(char character);                           // NOLINT(google-explicit-constructor)
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool>) TextPart(T number) {  // NOLINT(google-explicit-constructor)
    write(std::uint64_t{number});
  }
  template <std::signed_integral T>
  TextPart(T number) {  // NOLINT(google-explicit-constructor)
    write(std::int64_t{number});
  }
  TextPart(bool) = delete;    // which words, and how many digits, is for the caller to say
  TextPart(double) = delete;  // format_double(), fixed()
  TextPart(const TextPart&) = delete;
  TextPart& operator=(const TextPart&) = delete;

  [[nodiscard]] std::string_view text() const { return text_; }

 private:
  void write(std::uint64_t number);
  void write(std::int64_t number);

  std::array<char, 20> digits_;  // filled where the part is not a text
  std::string_view text_;
};

std::string concat_parts(std::initializer_list<TextPart> parts);

// The parts one after another, without anything between them: concat("site ", 7, " of ", name).
// Shorter to write and to compile than a chain of +, and allocates once.
template <class... Parts>
std::string concat(const Parts&... parts) {
  return concat_parts({TextPart(parts)...});
}

}  // namespace sightline
