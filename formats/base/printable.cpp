#include "formats/base/printable.h"

#include <cstddef>

namespace sightline {
namespace {

unsigned char byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

void escape(unsigned char byte, std::string& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out += "\\x";
  out += kDigits[byte >> 4];
  out += kDigits[byte & 15];
}

// Bytes of the character that begins here, 0 where it is no UTF-8 (RFC 3629).
std::size_t character_size(std::string_view text) {
  const unsigned char first = byte_at(text, 0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte_at(text, i) & 0xc0) != 0x80) return 0;
  }
  const unsigned char second = byte_at(text, 1);
  const bool is_too_long = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
  const bool is_no_character = (first == 0xed && second > 0x9f) || (first == 0xf4 && second > 0x8f);
  return is_too_long || is_no_character ? 0 : size;
}

// C0 and DEL, C1, and the marks that turn the direction of what follows around.
bool is_control(std::string_view character) {
  const unsigned char first = byte_at(character, 0);
  if (character.size() == 1)
    return (first < 0x20 && first != '\n' && first != '\t') || first == 127;
  if (character.size() == 2) return first == 0xc2 && byte_at(character, 1) < 0xa0;
  const bool is_mark = character.starts_with("\xe2\x80") || character.starts_with("\xe2\x81");
  if (!is_mark || character.size() != 3) return false;
  const unsigned char last = byte_at(character, 2);
  return byte_at(character, 1) == 0x80 ? last >= 0xaa && last <= 0xae
                                       : last >= 0xa6 && last <= 0xa9;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = character_size(text);
    const std::string_view character = text.substr(0, size == 0 ? 1 : size);
    if (size > 0 && !is_control(character)) {
      out += character;
    } else {
      for (const char c : character) escape(static_cast<unsigned char>(c), out);
    }
    text.remove_prefix(character.size());
  }
  return out;
}

}  // namespace sightline
