#pragma once

#include <string>
#include <string_view>

namespace sightline {

// Text from a file of strangers, fit for a terminal: control characters, also those of C1, marks
// that turn the direction of text around, other line ends of Unicode, and bytes that are no UTF-8
// become "\x1b". Line ends and tabs stay.
std::string printable(std::string_view text);

// A name in such a text: line ends and tabs are escaped too, so that it cannot begin a line, and
// what a CI service would take for a command (log_text()).
std::string one_line(std::string_view name);

// A text for a log: printable(), and what the log of a CI service would take for a command of its
// own ("::error ..." at the beginning of a line, "##[...]") is escaped.
std::string log_text(std::string_view text);

// JSON whose strings contain none of these characters: they become "\u202e". Line ends stay.
std::string printable_json(std::string_view json);

// The text as UTF-8; what is none becomes U+FFFD.
std::string utf8_text(std::string_view text);

}  // namespace sightline
