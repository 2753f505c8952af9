#include "formats/text/quoted_text.h"

#include <algorithm>
#include <cctype>

#include "formats/base/printable.h"

namespace sightline {
namespace {

// What a spreadsheet computes. "-1.5", "+2" and "-inf" are numbers, "-" is a sign for nothing.
bool is_formula(std::string_view text) {
  if (text.empty()) return false;
  if (text[0] == '=' || text[0] == '@') return true;
  if ((text[0] != '+' && text[0] != '-') || text.size() == 1) return false;
  const std::string_view rest = text.substr(1);
  return rest != "inf" && rest != "nan" &&
         rest.find_first_not_of("0123456789.eE+-") != std::string_view::npos;
}

// As %XX, what a workflow command would take for its own syntax.
std::string percent_escaped(std::string_view text, std::string_view reserved) {
  static constexpr const char* kDigits = "0123456789ABCDEF";
  std::string safe;
  for (const char c : text) {
    if (reserved.find(c) == std::string_view::npos) {
      safe += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    safe += {'%', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return safe;
}

bool is_plain_scalar(std::string_view text) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-./+").find(static_cast<char>(c)) != std::string_view::npos;
  };
  const bool is_number = text.find_first_not_of("-.0123456789") == std::string_view::npos;
  return !text.empty() && (text.front() != '-' || is_number) && std::ranges::all_of(text, is_plain);
}

}  // namespace

std::string csv_field(std::string_view text) {
  const std::string line = is_formula(text) ? "'" + one_line(text) : one_line(text);
  if (line.find_first_of(",\"") == std::string::npos) return line;
  std::string quoted = "\"";
  for (const char c : line) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string xml_text(std::string_view text) {
  std::string safe;
  for (const char c : printable(text)) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else if (c == '>') {
      safe += "&gt;";
    } else if (c == '"') {
      safe += "&quot;";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string markdown_text(std::string_view text) {
  std::string safe;
  for (const char c : one_line(text)) {
    if (c == '<') {
      safe += "&lt;";
    } else if (c == '@') {
      safe += "&#64;";
    } else {
      if (std::string_view("\\`*_[]|").find(c) != std::string_view::npos) safe += '\\';
      safe += c;
    }
  }
  return safe;
}

std::string markdown_code(std::string_view text) {
  std::string safe = one_line(text);
  std::ranges::replace(safe, '`', '\'');
  return safe;
}

std::string github_message(std::string_view text) {
  return percent_escaped(printable(text), "%\r\n");
}
std::string github_property(std::string_view text) {
  return percent_escaped(printable(text), "%\r\n:,");
}

// Bytes that are no UTF-8 cannot be written in YAML.
std::string yaml_scalar(std::string_view text) {
  if (is_plain_scalar(text)) return std::string(text);
  std::string quoted = "\"";
  for (const char c : utf8_text(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      quoted += one_line(std::string_view(&c, 1));
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return printable_json(quoted) + "\"";  // YAML has the escapes of JSON
}

std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string command_word(std::string_view text) {
  const bool is_plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("/-._~+,:@%").find(static_cast<char>(c)) != std::string_view::npos;
  });
  return is_plain && !text.empty() ? std::string(text) : shell_word(text);
}

}  // namespace sightline
