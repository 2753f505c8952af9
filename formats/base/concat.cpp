#include "formats/base/concat.h"

#include <charconv>
#include <cstddef>

namespace sightline {

TextPart::TextPart(char character) {
  digits_[0] = character;
  text_ = {digits_.data(), 1};
}

void TextPart::write(std::uint64_t number) {
  const std::to_chars_result end = std::to_chars(digits_.begin(), digits_.end(), number);
  text_ = {digits_.begin(), end.ptr};
}

void TextPart::write(std::int64_t number) {
  const std::to_chars_result end = std::to_chars(digits_.begin(), digits_.end(), number);
  text_ = {digits_.begin(), end.ptr};
}

std::string concat_parts(std::initializer_list<TextPart> parts) {
  std::size_t size = 0;
  for (const TextPart& part : parts) size += part.text().size();
  std::string text;
  text.reserve(size);
  for (const TextPart& part : parts) text += part.text();
  return text;
}

}  // namespace sightline
