#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

// Walks over lines; their ends (LF or CR LF) are not part of them.
class LineReader {
 public:
  explicit LineReader(std::string_view text, std::size_t offset = 0, std::size_t lines_before = 0)
      : text_(text), offset_(offset), number_(lines_before) {}

  // False when there is no further line.
  bool next(std::string_view& line) {
    if (offset_ >= text_.size()) return false;
    const std::size_t end = text_.find('\n', offset_);
    last_has_end_ = end != std::string_view::npos;
    line = text_.substr(offset_, last_has_end_ ? end - offset_ : std::string_view::npos);
    offset_ = last_has_end_ ? end + 1 : text_.size();
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number_;
    return true;
  }
  [[nodiscard]] std::size_t number() const { return number_; }  // of the line read last, from 1
  [[nodiscard]] std::size_t offset() const { return offset_; }  // of the first byte behind it
  [[nodiscard]] bool last_has_end() const { return last_has_end_; }

 private:
  std::string_view text_;
  std::size_t offset_;
  std::size_t number_;
  bool last_has_end_ = true;
};

// Without the mark that some editors of Windows put before UTF-8.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

// Words between any of the separators, none of them empty. `words` is reused.
inline void split_words(std::string_view line, std::vector<std::string_view>& words,
                        std::string_view separators = " \t\r") {
  words.clear();
  std::size_t first = line.find_first_not_of(separators);
  while (first != std::string_view::npos) {
    const std::size_t end = line.find_first_of(separators, first);
    words.push_back(line.substr(first, end - first));
    if (end == std::string_view::npos) return;
    first = line.find_first_not_of(separators, end);
  }
}

// Without the characters `around` it.
inline std::string_view trimmed(std::string_view text, std::string_view around = " \t") {
  const std::size_t first = text.find_first_not_of(around);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(around) - first + 1);
}

// What stands between separators, trimmed; also where nothing does.
inline std::vector<std::string_view> cells_of(std::string_view line, char separator,
                                              std::string_view around) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin), around));
    begin = end + 1;
  }
  return cells;
}

// The whole word as a number, independent of the locale; "nan" and "inf" are numbers of type
// double.
template <class T>
std::optional<T> to_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T number{};
  const std::from_chars_result end =
      std::from_chars(word.data(), word.data() + word.size(), number);
  if (end.ec != std::errc() || end.ptr != word.data() + word.size()) return std::nullopt;
  return number;
}

// A number that is finite.
inline std::optional<double> finite_number(std::string_view word) {
  const std::optional<double> number = to_number<double>(word);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// For messages: a word of a damaged file may be anything.
inline std::string in_quotes(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += c >= 0x20 && c < 0x7f ? c : '?';
  return text + (word.size() > kLongest ? "...'" : "'");
}

}  // namespace sightline
