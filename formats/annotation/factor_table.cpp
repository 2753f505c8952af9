#include "formats/annotation/factor_table.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

namespace sightline {
namespace {

// Of the i-th value of a site.
std::size_t factor_of(const FactorTable& table, std::size_t i) {
  if (i < table.shared_count) return i;
  return table.shared_count +
         (i - table.shared_count) % (table.factors.size() - table.shared_count);
}

// The values of some sites.
template <class Table>
auto values_of(Table& table, std::size_t first, std::size_t count) {
  const std::size_t per_site = table.values_per_site();
  return std::span(table.values).subspan(first * per_site, count * per_site);
}

}  // namespace

bool is_simulated(const FactorTable& table) {
  return std::ranges::find(table.factors, kSimulatedColumn) != table.factors.end();
}

Result<void> validate(const FactorTable& table) {
  SIGHTLINE_TRY(validate(table.looks));
  if (table.factors.empty()) return invalid_artifact("a factor table needs factors", "");
  if (std::set(table.factors.begin(), table.factors.end()).size() != table.factors.size()) {
    return invalid_artifact("two factors have the same name", "");
  }
  if (table.shared_count > table.factors.size()) {
    return invalid_artifact(
        concat("found ", table.shared_count, " factors that looks share of ", table.factors.size()),
        "");
  }
  const std::size_t per_site = table.values_per_site();
  if (table.values.size() != per_site * table.site_count) {
    return invalid_artifact(
        concat("found ", table.values.size(), " values, expected ", per_site * table.site_count),
        "");
  }
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    if (!std::isfinite(table.values[i])) {
      return invalid_artifact(table.factors[factor_of(table, i % per_site)] + " is not finite",
                              concat("site ", i / per_site));
    }
  }
  return {};
}

Table dump(const FactorTable& table) {
  Table text;
  text.name = "factors";
  text.columns = {"site", "range_m", "look"};
  text.columns.insert(text.columns.end(), table.factors.begin(), table.factors.end());
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t look = 0; look < table.looks.size(); ++look) {
      std::vector<Cell>& row = text.rows.emplace_back();
      row = {static_cast<std::int64_t>(site), table.looks[look].range_m,
             to_text(table.looks[look])};
      for (std::size_t factor = 0; factor < table.factors.size(); ++factor) {
        row.emplace_back(table.at(site, look, factor));
      }
    }
  }
  return text;
}

void encode(const FactorTable& table, ByteWriter& writer) { encode_whole(table, writer); }
void decode(ByteReader& reader, FactorTable& table) { decode_whole(reader, table); }

std::size_t RowsOf<FactorTable>::size(const FactorTable& head) {
  return head.values_per_site() * sizeof(double);
}

FactorTable RowsOf<FactorTable>::head_of(const FactorTable& table) {
  return part_of(table, 0, table.site_count);
}

FactorTable RowsOf<FactorTable>::part_of(const FactorTable& head, std::size_t /*first*/,
                                         std::size_t count) {
  return {head.looks, head.factors, static_cast<std::uint32_t>(count), head.shared_count, {}};
}

void RowsOf<FactorTable>::resize(FactorTable& head, std::size_t count) {
  head.values.resize(count * head.values_per_site());
}

void RowsOf<FactorTable>::encode_head(const FactorTable& table, ByteWriter& writer) {
  sightline::encode(table.looks, writer);
  writer.put<std::uint64_t>(table.factors.size());
  for (const std::string& factor : table.factors) writer.put_string(factor);
  writer.put(table.site_count);
  writer.put(table.shared_count);
}

void RowsOf<FactorTable>::decode_head(ByteReader& reader, FactorTable& table) {
  sightline::decode(reader, table.looks);
  table.factors.resize(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& factor : table.factors) reader.get_string(factor);
  reader.get(table.site_count);
  reader.get(table.shared_count);
  if (table.shared_count > table.factors.size()) reader.fail();
}

void RowsOf<FactorTable>::encode(const FactorTable& table, std::size_t first, std::size_t count,
                                 ByteWriter& writer) {
  const std::span<const double> values = values_of(table, first, count);
  writer.append(values.data(), values.size_bytes());
}

void RowsOf<FactorTable>::decode(ByteReader& reader, FactorTable& table, std::size_t first,
                                 std::size_t count) {
  for (double& value : values_of(table, first, count)) reader.get(value);
}

}  // namespace sightline
