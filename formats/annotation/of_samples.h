#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/drive/look.h"
#include "formats/tables/rows_of.h"

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

// Whether a table of samples has as many sites as its own.
template <HasRows Artifact>
bool has_one_site_count(const Artifact& artifact) {
  return std::ranges::all_of(artifact.of_samples, [&](const Artifact& samples) {
    return RowsOf<Artifact>::count(samples) == RowsOf<Artifact>::count(artifact);
  });
}

// Error: invalid-artifact where there is no such.
template <HasRows Artifact>
Result<void> validate_site_count(const Artifact& artifact) {
  if (has_one_site_count(artifact)) return {};
  return Error{ErrorCode::kInvalidArtifact, "found a table of samples of other sites", "",
               "of_samples"};
}

}  // namespace sightline
