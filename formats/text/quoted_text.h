#pragma once

#include <string>
#include <string_view>

// One function for each syntax that a name of a user is written into. Whatever bytes the name has,
// the result is UTF-8 without control characters, and reads back as one value. For terminals and
// logs: formats/base/printable.h; for JSON: formats/text/json_text.h.

namespace sightline {

// A field of CSV (RFC 4180): in quotes where a comma or quote would otherwise break it. Control
// characters are escaped (one_line()). A text that a spreadsheet would take for a formula begins
// with an apostrophe; numbers stay.
std::string csv_field(std::string_view text);

// The inside of an element or attribute of XML or HTML; line ends and tabs stay. Other control
// characters are escaped (printable()).
std::string xml_text(std::string_view text);

// Running text or a cell of a table in the Markdown of GitHub and GitLab, on one line: no syntax,
// no HTML, no user mentioned.
std::string markdown_text(std::string_view text);
// The inside of `code`.
std::string markdown_code(std::string_view text);

// The message and a property of a workflow command of GitHub ("::error file=PROPERTY::MESSAGE").
std::string github_message(std::string_view text);
std::string github_property(std::string_view text);

// A scalar of YAML: plain where it is read back as it stands, else in double quotes.
std::string yaml_scalar(std::string_view text);

// One word for a POSIX shell, in single quotes.
std::string shell_word(std::string_view text);
// The same, without quotes where a shell would neither split nor expand it.
std::string command_word(std::string_view text);

}  // namespace sightline
