#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/artifact_in_pieces.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"

namespace sightline {

// Map factors of every site at every look.
struct FactorTable {
  std::vector<Look> looks;           // from the cheapest to the dearest
  std::vector<std::string> factors;  // column names, "feature_count", ...
  std::uint32_t site_count = 0;
  // So many of the first factors are the same at all looks of a site and stand once: in a table of
  // samples, most of what it would hold.
  std::uint32_t shared_count = 0;
  std::vector<double> values;  // [site][shared factors, then by look the others]
  // The same of the looks that take a sample, the same sites and drive: none or one, without its
  // own.
  std::vector<FactorTable> of_samples;

  // Where no factor is shared.
  [[nodiscard]] SiteShape shape() const { return {looks.size(), factors.size()}; }

  [[nodiscard]] std::size_t values_per_site() const {
    return shared_count + looks.size() * (factors.size() - shared_count);
  }

  [[nodiscard]] double at(std::size_t site, std::size_t range, std::size_t factor) const {
    const std::size_t first = site * values_per_site();
    if (factor < shared_count) return values[first + factor];
    return values[first + range * (factors.size() - shared_count) + factor];
  }
};

template <>
struct ArtifactTraits<FactorTable> {
  static constexpr std::string_view kName = "factor-table";
  static constexpr std::uint32_t kVersion = 3;
};

// The column of ones that says that simulated scans stand where those of drives would
// (schemas/definitions.md, "Annotating a finished map").
inline constexpr std::string_view kSimulatedColumn = "simulated";
[[nodiscard]] bool is_simulated(const FactorTable& table);

Result<void> validate(const FactorTable& table);
Table dump(const FactorTable& table);
void encode(const FactorTable& table, ByteWriter& writer);
void decode(ByteReader& reader, FactorTable& table);
// The same bytes: of a large field they are not in memory twice.
std::uint64_t payload_size(const FactorTable& table);
Result<void> visit_payload(const FactorTable& table, const ByteSink& sink);
Result<void> open_payload(const StoredBytes& payload, FactorTable& table);

// What they are made of, for the looks that take every return and again for those that do not: all
// but the values, their count, and the values one after another.
void encode_head(const FactorTable& table, ByteWriter& writer);
void decode_head(ByteReader& reader, FactorTable& table);

}  // namespace sightline
