#include "formats/base/printable.h"

#include <algorithm>
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

// C0 and DEL, C1, line ends of Unicode, and the marks that turn the direction of what follows
// around.
bool is_control(std::string_view character) {
  const unsigned char first = byte_at(character, 0);
  if (character.size() == 1) return first < 0x20 || first == 127;
  if (character.size() == 2) {
    const bool is_arabic_mark = first == 0xd8 && byte_at(character, 1) == 0x9c;
    return is_arabic_mark || (first == 0xc2 && byte_at(character, 1) < 0xa0);
  }
  const bool is_mark = character.starts_with("\xe2\x80") || character.starts_with("\xe2\x81");
  if (!is_mark || character.size() != 3) return false;
  const unsigned char last = byte_at(character, 2);
  if (byte_at(character, 1) != 0x80) return last >= 0xa6 && last <= 0xa9;
  return last == 0x8e || last == 0x8f || (last >= 0xa8 && last <= 0xae);
}

std::string escaped(std::string_view text, std::string_view kept) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t size = character_size(text);
    const std::string_view character = text.substr(0, size == 0 ? 1 : size);
    const bool is_kept = kept.find(character.front()) != std::string_view::npos;
    if (size > 0 && (is_kept || !is_control(character))) {
      out += character;
    } else {
      for (const char c : character) escape(static_cast<unsigned char>(c), out);
    }
    text.remove_prefix(character.size());
  }
  return out;
}

// Of a character of one to three bytes.
unsigned code_point(std::string_view character) {
  if (character.size() == 1) return byte_at(character, 0);
  unsigned code = byte_at(character, 0) & (character.size() == 2 ? 0x1fU : 0x0fU);
  for (std::size_t i = 1; i < character.size(); ++i) {
    code = (code << 6U) | (byte_at(character, i) & 0x3fU);
  }
  return code;
}

void escape_for_json(unsigned code, std::string& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out += "\\u";
  for (const unsigned shift : {12U, 8U, 4U, 0U}) out += kDigits[(code >> shift) & 15U];
}

constexpr std::string_view kOlderCommand = "##[";  // anywhere in a line of a CI service's log

// Whether a service would read a command from here on: blanks before "::" do not hinder it.
bool begins_command(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && line.substr(first).starts_with("::");
}

std::string without_commands(std::string_view text) {
  std::string out;
  bool begins_line = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    const bool is_command = begins_line && begins_command(rest.substr(0, rest.find('\n')));
    if (is_command) {
      const std::size_t colon = rest.find(':');
      out.append(rest.substr(0, colon)).append("\\x3a");
      i += colon;
    } else if (rest.starts_with(kOlderCommand)) {
      out += "\\x23";
    } else {
      out += text[i];
    }
    begins_line = text[i] == '\n';
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text) { return escaped(text, "\n\t"); }

std::string one_line(std::string_view name) { return without_commands(escaped(name, "")); }

std::string log_text(std::string_view text) { return without_commands(printable(text)); }

std::string printable_json(std::string_view json) {
  // What such characters begin with: nearly no text has one.
  const bool is_plain = json.find_first_of("\x7f\xc2\xd8\xe2") == std::string_view::npos;
  if (is_plain && json.find(kOlderCommand) == std::string_view::npos) return std::string(json);
  std::string out;
  out.reserve(json.size());
  while (!json.empty()) {
    if (json.starts_with(kOlderCommand)) {
      escape_for_json('#', out);
      json.remove_prefix(1);
      continue;
    }
    const std::string_view character =
        json.substr(0, std::max<std::size_t>(character_size(json), 1));
    if (character != "\n" && is_control(character)) {
      escape_for_json(code_point(character), out);
    } else {
      out += character;
    }
    json.remove_prefix(character.size());
  }
  return out;
}

std::string utf8_text(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t size = character_size(text);
    out += size == 0 ? std::string_view("\xef\xbf\xbd") : text.substr(0, size);
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return out;
}

}  // namespace sightline
