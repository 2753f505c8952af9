#pragma once

#include <string>
#include <string_view>

// Text made fit for the syntax that it is put into.

namespace sightline {

// A field of CSV (RFC 4180): in quotes where a comma, quote or line end would otherwise break it.
std::string csv_field(std::string_view text);

// The inside of an element or attribute of XML or HTML. Control characters that XML 1.0 does not
// know are dropped.
std::string xml_text(std::string_view text);

// One word for a POSIX shell, in single quotes.
std::string shell_word(std::string_view text);
// The same, without quotes where a shell would neither split nor expand it.
std::string command_word(std::string_view text);

}  // namespace sightline
