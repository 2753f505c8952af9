#include "formats/release/record_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>

namespace sightline {
namespace {

bool is_word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

// Decimal digits only, without leading zeros.
std::optional<std::uint64_t> number_of(std::string_view word) {
  std::uint64_t value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, failure] = std::from_chars(word.data(), end, value);
  if (failure != std::errc() || stop != end || std::to_string(value) != word) return {};
  return value;
}

}  // namespace

RecordReader::RecordReader(std::string_view text) : rest_(text) {
  if (text.size() > kLargestRecord) {
    fail(concat("found ", text.size(), " bytes, expected at most ", kLargestRecord));
  }
}

void RecordReader::fail(const std::string& message, ErrorCode code) {
  if (!error_) error_ = Error{code, message, "", concat("line ", line_)};
  rest_ = {};
}

bool RecordReader::next_is(std::string_view key) const {
  return rest_.starts_with(key) && rest_.substr(key.size()).starts_with(' ');
}

std::string_view RecordReader::take(std::string_view key) {
  line_ += 1;
  const std::size_t end = rest_.find('\n');
  if (!next_is(key) || end == std::string_view::npos) {
    fail(concat("expected a line \"", key, " ...\""));
    return {};
  }
  const std::string_view value = rest_.substr(key.size() + 1, end - key.size() - 1);
  rest_.remove_prefix(end + 1);
  return value;
}

std::vector<std::string_view> RecordReader::take_words(std::string_view key, std::size_t count) {
  std::string_view value = take(key);
  std::vector<std::string_view> words;
  for (std::size_t end = value.find(' '); end != std::string_view::npos; end = value.find(' ')) {
    words.push_back(value.substr(0, end));
    value.remove_prefix(end + 1);
  }
  words.push_back(value);
  if (words.size() != count) {
    fail(concat("found ", words.size(), " words, expected ", count));
    words.assign(count, std::string_view());
  }
  return words;
}

std::string RecordReader::take_name(std::string_view key) {
  const std::string_view value = take(key);
  if (!is_record_name(value)) fail("expected a name of letters, digits and . _ - :");
  return std::string(value);
}

std::uint64_t RecordReader::take_number(std::string_view key) { return number(take(key)); }

std::int64_t RecordReader::take_time(std::string_view key) {
  const std::optional<std::int64_t> seconds = utc_seconds(take(key));
  if (!seconds) fail("expected a time such as 2026-12-01T00:00:00Z");
  return seconds.value_or(0);
}

Digest RecordReader::take_digest(std::string_view key) { return digest(take(key)); }

std::uint64_t RecordReader::number(std::string_view word) {
  const std::optional<std::uint64_t> value = number_of(word);
  if (!value) fail("expected a number without leading zeros, below 2^64");
  return value.value_or(0);
}

Digest RecordReader::digest(std::string_view word) {
  const std::optional<Digest> value = digest_of_hex(word);
  if (!value) fail("expected 64 lower-case hexadecimal digits");
  return value.value_or(Digest{});
}

std::string RecordReader::file_name(std::string_view word) {
  if (!is_safe_file_name(word)) {
    fail(concat("the file name \"", word.substr(0, 100),
                "\" is not a plain name of letters, digits and . _ -"),
         ErrorCode::kUnsafeName);
  }
  return std::string(word);
}

Result<void> RecordReader::finish() {
  if (!error_ && !rest_.empty()) {
    line_ += 1;
    fail("expected the end of the record");
  }
  if (error_) return *error_;
  return {};
}

std::string utc_text(std::int64_t seconds) {
  const std::chrono::sys_seconds time{std::chrono::seconds(seconds)};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(time - day);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ",
                static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                static_cast<unsigned>(date.day()), static_cast<int>(clock.hours().count()),
                static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()));
  return text.data();
}

std::optional<std::int64_t> utc_seconds(std::string_view text) {
  constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
  if (text.size() != kForm.size()) return {};
  for (std::size_t i = 0; i < kForm.size(); ++i) {
    const bool is_digit = text[i] >= '0' && text[i] <= '9';
    if (kForm[i] == 'd' ? !is_digit : text[i] != kForm[i]) return {};
  }
  const auto field = [&](std::size_t begin, std::size_t size) {
    int value = 0;
    std::from_chars(text.data() + begin, text.data() + begin + size, value);
    return value;
  };
  const std::chrono::year_month_day date{std::chrono::year(field(0, 4)),
                                         std::chrono::month(static_cast<unsigned>(field(5, 2))),
                                         std::chrono::day(static_cast<unsigned>(field(8, 2)))};
  if (!date.ok() || field(0, 4) < 1970) return {};
  if (field(11, 2) > 23 || field(14, 2) > 59 || field(17, 2) > 59) return {};
  const std::chrono::sys_seconds time =
      std::chrono::sys_days(date) + std::chrono::hours(field(11, 2)) +
      std::chrono::minutes(field(14, 2)) + std::chrono::seconds(field(17, 2));
  return time.time_since_epoch().count();
}

bool is_safe_file_name(std::string_view name) {
  return !name.empty() && name.size() <= 100 && name.front() != '.' && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), is_word_character);
}

bool is_plain_text(std::string_view text) {
  return !text.empty() && text.size() <= 128 && text.front() != ' ' && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

bool is_record_name(std::string_view text) {
  return !text.empty() && text.size() <= 128 && std::all_of(text.begin(), text.end(), [](char c) {
    return is_word_character(c) || c == ':';
  });
}

std::optional<Digest> digest_of_hex(std::string_view text) {
  Digest digest{};
  if (text.size() != 2 * digest.size()) return {};
  for (std::size_t i = 0; i < digest.size(); ++i) {
    const char* begin = text.data() + 2 * i;
    const auto [stop, failure] = std::from_chars(begin, begin + 2, digest[i], 16);
    if (failure != std::errc() || stop != begin + 2) return {};
  }
  if (to_hex(digest) != text) return {};
  return digest;
}

}  // namespace sightline
