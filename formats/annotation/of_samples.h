#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/base/result.h"
#include "formats/drive/look.h"

// Tables of a map come twice: for the looks that take every return, the paper's observation ranges,
// and as `of_samples` for those that take a sample. Both are made by the same code, each in its
// turn.

namespace sightline {

// `encode_own`: writes an artifact without its of_samples.
template <class Artifact, class EncodeOwn>
void encode_both(const Artifact& artifact, ByteWriter& writer, const EncodeOwn& encode_own) {
  encode_own(artifact, writer);
  writer.put(static_cast<std::uint8_t>(artifact.of_samples.size()));
  for (const Artifact& samples : artifact.of_samples) encode_own(samples, writer);
}

template <class Artifact, class DecodeOwn>
void decode_both(ByteReader& reader, Artifact& artifact, const DecodeOwn& decode_own) {
  decode_own(reader, artifact);
  const auto count = reader.get<std::uint8_t>();
  if (count > 1) reader.fail();
  artifact.of_samples.resize(reader.ok() ? count : 0);
  for (Artifact& samples : artifact.of_samples) decode_own(reader, samples);
}

// The same bytes piece by piece. `visit_own`: of an artifact without its of_samples. Errors: those
// of the sink.
template <class Artifact, class VisitOwn>
Result<void> visit_both(const Artifact& artifact, const ByteSink& sink, const VisitOwn& visit_own) {
  SIGHTLINE_TRY(visit_own(artifact, sink));
  const auto count = static_cast<std::uint8_t>(artifact.of_samples.size());
  SIGHTLINE_TRY(sink(std::as_bytes(std::span(&count, 1))));
  for (const Artifact& samples : artifact.of_samples) SIGHTLINE_TRY(visit_own(samples, sink));
  return {};
}

// Reads both tables from `offset` on, which moves behind them; false where bytes make no sense or
// some are left. Errors: cannot-read, those of open_own.
template <class Artifact, class OpenOwn>
Result<bool> open_both(const StoredBytes& payload, std::uint64_t& offset, Artifact& artifact,
                       const OpenOwn& open_own) {
  SIGHTLINE_TRY(open_own(payload, offset, artifact));
  if (offset == payload.size()) return false;
  std::uint8_t count = 0;
  SIGHTLINE_TRY(payload.read(offset++, std::as_writable_bytes(std::span(&count, 1))));
  if (count > 1) return false;
  artifact.of_samples.resize(count);
  for (Artifact& samples : artifact.of_samples) SIGHTLINE_TRY(open_own(payload, offset, samples));
  return offset == payload.size();
}

// All that precedes the values of a table (decode_head), and how many values of at least so many
// bytes stand behind it, from `offset` on, which moves behind that number. Nothing where the bytes
// make no sense. Error: cannot-read.
template <class Artifact>
Result<std::optional<std::uint64_t>> read_head(const StoredBytes& payload, std::uint64_t& offset,
                                               Artifact& table, std::size_t bytes_of_value) {
  // Most heads are short; that of many sites may be long.
  constexpr std::uint64_t kShort = std::uint64_t{1} << 16;
  const std::uint64_t rest = payload.size() - offset;
  for (std::uint64_t size = kShort;; size *= 2) {
    const std::uint64_t read = std::min(rest, size);
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, payload.read(offset, read));
    ByteReader reader(bytes);
    Artifact found;
    decode_head(reader, found);
    const auto count = reader.template get<std::uint64_t>();
    if (!reader.ok() && read < rest) continue;
    if (!reader.ok() || count > (rest - reader.offset()) / bytes_of_value) {
      return std::optional<std::uint64_t>();
    }
    table = std::move(found);
    offset += reader.offset();
    return std::optional(count);
  }
}

// `looks_of`: the looks of an artifact. Error: invalid-artifact, or what validate_own returns.
template <class Artifact, class ValidateOwn, class LooksOf>
Result<void> validate_both(const Artifact& artifact, const ValidateOwn& validate_own,
                           const LooksOf& looks_of) {
  const auto invalid = [](const std::string& message) {
    return Error{ErrorCode::kInvalidArtifact, message, "", "of_samples"};
  };
  SIGHTLINE_TRY(validate_own(artifact));
  if (artifact.of_samples.size() > 1) return invalid("found more than one table of samples");
  for (const Artifact& samples : artifact.of_samples) {
    SIGHTLINE_TRY(validate_own(samples));
    if (!samples.of_samples.empty()) return invalid("found a table of samples within another");
    if (std::ranges::any_of(looks_of(samples), takes_every_return) ||
        !std::ranges::all_of(looks_of(artifact), takes_every_return)) {
      return invalid("a look stands in the other table");
    }
  }
  return {};
}

}  // namespace sightline
