#include "compiler/cli/quoted_place.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "formats/base/files/regular_file.h"
#include "formats/base/printable.h"

namespace sightline {
namespace {

constexpr std::size_t kLargestText = std::size_t{1} << 20;
constexpr std::size_t kWidestQuote = 96;  // bytes; with the indent a line of 100 columns

// The line with this number, from 1; empty: there is none.
std::string line_of(const std::string& text, int number) {
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i < number; ++i) {
    if (!std::getline(lines, line)) return "";
  }
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

// Characters of UTF-8 in so many bytes: those that continue one do not count.
std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::string quoted_place(const Error& error) {
  int line_number = 0;
  int column = 0;
  char rest = 0;
  const int read =
      std::sscanf(error.place.c_str(), "line %d, column %d%c", &line_number, &column, &rest);
  if (read != 2 || line_number < 1 || column < 1 || error.file.empty()) return "";
  const Result<std::string> text = read_beginning(error.file, kLargestText);
  if (!text) return "";
  std::string line = line_of(*text, line_number);
  std::ranges::replace(line, '\t', ' ');  // a tab is one column of the place
  const auto at = static_cast<std::size_t>(column - 1);
  if (line.find_first_not_of(' ') == std::string::npos || at > line.size()) return "";
  if (at >= kWidestQuote) return "";
  const std::string before = printable(std::string_view(line).substr(0, at));
  return concat("    ", printable(line.substr(0, kWidestQuote)), "\n    ",
                std::string(characters(before), ' '), "^\n");
}

}  // namespace sightline
