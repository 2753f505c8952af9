#include "formats/annotation/factor_table.h"

#include <cmath>
#include <set>

namespace sightline {
namespace {

Error invalid(std::string message, std::string place) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "", std::move(place)};
}

}  // namespace

Result<void> validate(const FactorTable& table) {
  if (table.ranges_m.empty() || table.factors.empty()) {
    return invalid("a factor table needs ranges and factors", "");
  }
  for (std::size_t r = 0; r < table.ranges_m.size(); ++r) {
    const double before_m = r == 0 ? 0.0 : table.ranges_m[r - 1];
    if (!(table.ranges_m[r] > before_m) || !std::isfinite(table.ranges_m[r])) {
      return invalid("ranges must ascend from above 0", "range " + std::to_string(r));
    }
  }
  if (std::set(table.factors.begin(), table.factors.end()).size() != table.factors.size()) {
    return invalid("two factors have the same name", "");
  }
  const SiteShape shape = table.shape();
  if (table.values.size() != shape.size(table.site_count)) {
    return invalid("found " + std::to_string(table.values.size()) + " values, expected " +
                       std::to_string(shape.size(table.site_count)),
                   "");
  }
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    if (!std::isfinite(table.values[i])) {
      return invalid(table.factors[shape.column_of(i)] + " is not finite",
                     "site " + std::to_string(shape.site_of(i)));
    }
  }
  return {};
}

Table dump(const FactorTable& table) {
  Table text;
  text.name = "factors";
  text.columns = {"site", "range_m"};
  text.columns.insert(text.columns.end(), table.factors.begin(), table.factors.end());
  text.rows.reserve(table.site_count * table.ranges_m.size());
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t range = 0; range < table.ranges_m.size(); ++range) {
      std::vector<Cell> row = {static_cast<std::int64_t>(site), table.ranges_m[range]};
      for (std::size_t factor = 0; factor < table.factors.size(); ++factor) {
        row.emplace_back(table.at(site, range, factor));
      }
      text.rows.push_back(std::move(row));
    }
  }
  return text;
}

void encode(const FactorTable& table, ByteWriter& writer) {
  writer.put_array(table.ranges_m);
  writer.put<std::uint64_t>(table.factors.size());
  for (const std::string& factor : table.factors) writer.put_string(factor);
  writer.put(table.site_count);
  writer.put_array(table.values);
}

void decode(ByteReader& reader, FactorTable& table) {
  reader.get_array(table.ranges_m);
  table.factors.resize(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& factor : table.factors) reader.get_string(factor);
  reader.get(table.site_count);
  reader.get_array(table.values);
}

}  // namespace sightline
