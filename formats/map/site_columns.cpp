#include "formats/map/site_columns.h"

#include <cstring>

#include "formats/map/container/packed_block.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {

std::string column_section(std::string_view name) {
  return std::string(kColumnSection) + std::string(name);
}

std::vector<std::byte> encode_column(const SiteColumn& column) {
  if (column.steps.empty()) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(column.values));
    return {bytes.begin(), bytes.end()};
  }
  std::vector<std::byte> numbers;
  for (const float value : column.values) {
    numbers.push_back(static_cast<std::byte>(step_of(column, value)));
  }
  return numbers;
}

Result<void> check_column(const MapContainer& container, std::string_view name,
                          std::span<const std::byte> raw) {
  const Digest digest = sha256(raw);
  for (const schema::SiteColumn* column : *container.manifest->columns()) {
    if (column->name()->string_view() != name) continue;
    if (to_digest(*column->digest()) == digest) return {};
  }
  return wrong_digest("the column", "");
}

Result<void> decode_column(std::span<const std::byte> raw, std::size_t site_count,
                           SiteColumn& column) {
  const std::size_t size = column.steps.empty() ? sizeof(float) : 1;
  const std::string place = "section " + column_section(column.name);
  if (raw.size() != site_count * size) {
    return Error{ErrorCode::kBadLayer,
                 concat("found ", raw.size(), " bytes, expected ", site_count * size), "", place};
  }
  if (!column.steps.empty()) {
    column.values.clear();
    for (const std::byte number : raw) {
      const auto step = static_cast<std::size_t>(number);
      if (step >= column.steps.size()) {
        return Error{ErrorCode::kBadLayer, concat("found step ", step, ", which is not listed"), "",
                     place};
      }
      column.values.push_back(column.steps[step]);
    }
    return {};
  }
  column.values.resize(site_count);
  if (site_count > 0) std::memcpy(column.values.data(), raw.data(), raw.size());
  return {};
}

Result<void> validate_columns(const std::vector<SiteColumn>& columns, std::size_t site_count) {
  if (columns.size() > kMostColumns) {
    return invalid_artifact("more columns of sites than a map can contain", "compiled map");
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    SIGHTLINE_TRY(validate(columns[i]));
    if (columns[i].values.size() != site_count) {
      return invalid_artifact("column " + columns[i].name + " is of other sites", "compiled map");
    }
    if (i > 0 && columns[i - 1].name >= columns[i].name) {
      return invalid_artifact("the names of columns do not ascend", "compiled map");
    }
  }
  return {};
}

}  // namespace sightline
