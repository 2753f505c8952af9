#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "formats/base/result.h"
#include "formats/release/admission.h"
#include "formats/release/signing_key.h"

// Files and clock of the verbs that sign and admit.

namespace sightline {

// The first line of a file, "-" for stdin; nothing for no name. Errors: those of reading.
Result<std::optional<std::string>> read_passphrase(const std::string& file);

// A new file that only its owner may read, whole on the disk. Errors: output-exists, cannot-write.
Result<void> write_secret_file(const std::string& path, const std::string& text);

Result<SecretKey> read_secret_key(const std::string& file, const std::string& passphrase_file);
Result<PublicKey> read_public_key(const std::string& file);

std::string signatures_of(const std::string& file);

// "2026-12-01T00:00:00Z", or "+30d": so many days from now; the clock's time for no text.
// Error: bad-argument.
Result<std::int64_t> read_time(const std::string& text);

}  // namespace sightline
