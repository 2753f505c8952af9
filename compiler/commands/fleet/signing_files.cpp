#include "compiler/commands/fleet/signing_files.h"

#include <charconv>
#include <chrono>
#include <iostream>

#include "compiler/cli/console/console.h"
#include "formats/base/files/atomic_file.h"
#include "formats/release/record_text.h"

namespace sightline {
namespace {

std::int64_t clock_s() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::seconds>(now).count();
}

// "+30d"
std::optional<std::int64_t> days_ahead(std::string_view text) {
  if (!text.starts_with('+') || !text.ends_with('d')) return {};
  const std::string_view digits = text.substr(1, text.size() - 2);
  std::int64_t days = 0;
  const auto [stop, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), days);
  if (failure != std::errc() || stop != digits.data() + digits.size()) return {};
  if (days < 0 || days > 36500) return {};
  return days;
}

// No longer than a file of it may be.
Result<std::optional<std::string>> first_line_of_stdin() {
  std::string line;
  for (char c = 0; std::cin.get(c) && c != '\n';) {
    if (line.size() == kLargestRecord) {
      return Error{ErrorCode::kTooLarge,
                   concat("more than ", kLargestRecord, " bytes, which no passphrase has"),
                   "stdin"};
    }
    line += c;
  }
  return std::optional<std::string>(line);
}

}  // namespace

Result<std::optional<std::string>> read_passphrase(const std::string& file) {
  if (file.empty()) return std::optional<std::string>();
  if (file == "-") return first_line_of_stdin();
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLargestRecord));
  return std::optional<std::string>(text.substr(0, text.find('\n')));
}

Result<void> write_secret_file(const std::string& path, const std::string& text) {
  const Result<void> written =
      write_file_atomically(path, text, IfExists::kRefuse, FileAccess::kOwner);
  if (written || written.error().code != ErrorCode::kOutputExists) return written;
  return Error{ErrorCode::kOutputExists, "a secret key is never replaced", path};
}

Result<SecretKey> read_secret_key(const std::string& file, const std::string& passphrase_file) {
  SIGHTLINE_ASSIGN(const std::optional<std::string> passphrase, read_passphrase(passphrase_file));
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLargestRecord));
  Result<SecretKey> key = decode_secret_key_file(text, passphrase);
  if (!key) return in_file(key.error(), file);
  return key;
}

Result<PublicKey> read_public_key(const std::string& file) {
  SIGHTLINE_ASSIGN(const std::string text, read_short_text(file, kLargestRecord));
  const Result<PublicKey> key = decode_public_key_file(text);
  if (!key) return in_file(key.error(), file);
  return key;
}

std::string signatures_of(const std::string& file) { return file + ".minisig"; }

Result<std::int64_t> read_time(const std::string& text) {
  if (text.empty()) return clock_s();
  if (const std::optional<std::int64_t> days = days_ahead(text)) return clock_s() + *days * 86400;
  const std::optional<std::int64_t> seconds = utc_seconds(text);
  if (seconds) return *seconds;
  return Error{ErrorCode::kBadArgument,
               concat("found \"", text, "\", expected a time as 2026-12-01T00:00:00Z or +30d")};
}

}  // namespace sightline
