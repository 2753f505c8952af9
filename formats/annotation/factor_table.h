#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"

namespace sightline {

// Map factors of every site at every look.
struct FactorTable {
  std::vector<Look> looks;           // from the cheapest to the dearest
  std::vector<std::string> factors;  // column names, "feature_count", ...
  std::uint32_t site_count = 0;
  std::vector<double> values;  // [site][look][factor]
  // The same of the looks that take a sample, the same sites and drive: none or one, without its
  // own.
  std::vector<FactorTable> of_samples;

  [[nodiscard]] SiteShape shape() const { return {looks.size(), factors.size()}; }

  [[nodiscard]] double at(std::size_t site, std::size_t range, std::size_t factor) const {
    return values[shape().index(site, range, factor)];
  }
};

template <>
struct ArtifactTraits<FactorTable> {
  static constexpr std::string_view kName = "factor-table";
  static constexpr std::uint32_t kVersion = 2;
};

// The column of ones that says that simulated scans stand where those of drives would
// (schemas/definitions.md, "Annotating a finished map").
inline constexpr std::string_view kSimulatedColumn = "simulated";
[[nodiscard]] bool is_simulated(const FactorTable& table);

Result<void> validate(const FactorTable& table);
Table dump(const FactorTable& table);
void encode(const FactorTable& table, ByteWriter& writer);
void decode(ByteReader& reader, FactorTable& table);

}  // namespace sightline
