#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"

// Records are lines "key value\n" in one fixed order, each value with one way to write it
// (schemas/release_format.md).

namespace sightline {

inline constexpr std::size_t kLargestRecord = 65536;

// Takes the lines of a record in order. After the first wrong one everything else is empty, so a
// decoder may read a whole record and ask once.
class RecordReader {
 public:
  // Error: malformed-record where `text` is longer than any record.
  explicit RecordReader(std::string_view text);

  // The next line's value; its key must be this one.
  std::string_view take(std::string_view key);
  [[nodiscard]] bool next_is(std::string_view key) const;
  // The values of one line, separated by single spaces, exactly `count` of them.
  std::vector<std::string_view> take_words(std::string_view key, std::size_t count);

  // The same, read as what they must be.
  std::string take_name(std::string_view key);  // letters, digits, '.', '_', '-', ':'; 1 to 128
  std::uint64_t take_number(std::string_view key);
  std::int64_t take_time(std::string_view key);
  Digest take_digest(std::string_view key);
  std::uint64_t number(std::string_view word);
  Digest digest(std::string_view word);
  std::string file_name(std::string_view word);

  // Remembers the first complaint, with the line taken last.
  void fail(const std::string& message, ErrorCode code = ErrorCode::kMalformedRecord);
  // That the record ends here, and the first complaint otherwise.
  [[nodiscard]] Result<void> finish();

 private:
  std::string_view rest_;
  std::size_t line_ = 0;
  std::optional<Error> error_;
};

// "2026-12-01T00:00:00Z"; seconds since 1970, years 1970 to 9999.
std::string utc_text(std::int64_t seconds);
std::optional<std::int64_t> utc_seconds(std::string_view text);

// One part of a path, with nothing in it that means anything to a shell, a server or a file system:
// letters, digits, '.', '_', '-', not starting with '.' or '-', 1 to 100 of them.
bool is_safe_file_name(std::string_view name);

// Printable ASCII without a space at either end, 1 to 128 characters.
bool is_plain_text(std::string_view text);
// Letters, digits, '.', '_', '-', ':'; 1 to 128.
bool is_record_name(std::string_view text);

// 64 lower-case hexadecimal digits.
std::optional<Digest> digest_of_hex(std::string_view text);

}  // namespace sightline
