#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/annotation/by_family.h"
#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"

namespace sightline {

// Map factors of every site at every look of a family.
struct FactorTable {
  std::vector<Look> looks;           // from the cheapest to the dearest
  std::vector<std::string> factors;  // column names, "feature_count", ...
  std::uint32_t site_count = 0;
  // So many of the first factors are the same at all looks of a site and stand once: in a table of
  // samples, most of what it would hold.
  std::uint32_t shared_count = 0;
  std::vector<double> values;  // [site][shared factors, then by look the others]

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
  static constexpr std::uint32_t kVersion = 5;
};

// The column of ones that says that simulated scans stand where those of drives would
// (schemas/definitions.md, "Annotating a finished map").
inline constexpr std::string_view kSimulatedColumn = "simulated";
[[nodiscard]] bool is_simulated(const FactorTable& table);

Result<void> validate(const FactorTable& table);
Table dump(const FactorTable& table);
void encode(const FactorTable& table, ByteWriter& writer);
void decode(ByteReader& reader, FactorTable& table);

// A row has all values of a site.
template <>
struct RowsOf<FactorTable> {
  static std::size_t size(const FactorTable& head);
  static std::size_t count(const FactorTable& table) { return table.site_count; }
  static FactorTable head_of(const FactorTable& table);
  static FactorTable part_of(const FactorTable& head, std::size_t first, std::size_t count);
  static void resize(FactorTable& head, std::size_t count);
  static void encode_head(const FactorTable& table, ByteWriter& writer);
  static void decode_head(ByteReader& reader, FactorTable& table);
  static void encode(const FactorTable& table, std::size_t first, std::size_t count,
                     ByteWriter& writer);
  static void decode(ByteReader& reader, FactorTable& table, std::size_t first, std::size_t count);
};

}  // namespace sightline
