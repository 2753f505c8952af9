#include "formats/annotation/factor_table.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include "formats/annotation/of_samples.h"

namespace sightline {
namespace {

// Of the i-th value of a site.
std::size_t factor_of(const FactorTable& table, std::size_t i) {
  if (i < table.shared_count) return i;
  return table.shared_count +
         (i - table.shared_count) % (table.factors.size() - table.shared_count);
}

Result<void> validate_own(const FactorTable& table) {
  SIGHTLINE_TRY(validate(table.looks));
  if (table.factors.empty()) return invalid_artifact("a factor table needs factors", "");
  if (std::set(table.factors.begin(), table.factors.end()).size() != table.factors.size()) {
    return invalid_artifact("two factors have the same name", "");
  }
  if (table.shared_count > table.factors.size()) {
    return invalid_artifact("found " + std::to_string(table.shared_count) +
                                " factors that looks share of " +
                                std::to_string(table.factors.size()),
                            "");
  }
  const std::size_t per_site = table.values_per_site();
  if (table.values.size() != per_site * table.site_count) {
    return invalid_artifact("found " + std::to_string(table.values.size()) + " values, expected " +
                                std::to_string(per_site * table.site_count),
                            "");
  }
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    if (!std::isfinite(table.values[i])) {
      return invalid_artifact(table.factors[factor_of(table, i % per_site)] + " is not finite",
                              "site " + std::to_string(i / per_site));
    }
  }
  return {};
}

const std::vector<Look>& looks_of(const FactorTable& table) { return table.looks; }

void encode_own_head(const FactorTable& table, ByteWriter& writer) {
  encode(table.looks, writer);
  writer.put<std::uint64_t>(table.factors.size());
  for (const std::string& factor : table.factors) writer.put_string(factor);
  writer.put(table.site_count);
  writer.put(table.shared_count);
}

void decode_own_head(ByteReader& reader, FactorTable& table) {
  decode(reader, table.looks);
  table.factors.resize(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& factor : table.factors) reader.get_string(factor);
  reader.get(table.site_count);
  reader.get(table.shared_count);
  if (table.shared_count > table.factors.size()) reader.fail();
}

// The values of some sites.
template <class Table>
auto values_of(Table& table, std::size_t first, std::size_t count) {
  const std::size_t per_site = table.values_per_site();
  return std::span(table.values).subspan(first * per_site, count * per_site);
}

// A cell that the table has no factor for stays empty.
void append_rows(const FactorTable& table, Table& text) {
  for (std::size_t site = 0; site < table.site_count; ++site) {
    for (std::size_t look = 0; look < table.looks.size(); ++look) {
      std::vector<Cell> row = {static_cast<std::int64_t>(site), table.looks[look].range_m,
                               to_text(table.looks[look])};
      for (std::size_t factor = 0; factor < table.factors.size(); ++factor) {
        row.emplace_back(table.at(site, look, factor));
      }
      row.resize(text.columns.size(), std::string());
      text.rows.push_back(std::move(row));
    }
  }
}

}  // namespace

bool is_simulated(const FactorTable& table) {
  return std::ranges::find(table.factors, kSimulatedColumn) != table.factors.end();
}

Result<void> validate(const FactorTable& table) {
  SIGHTLINE_TRY(validate_both(table, validate_own, looks_of));
  return validate_site_count(table);
}

Table dump(const FactorTable& table) {
  Table text;
  text.name = "factors";
  text.columns = {"site", "range_m", "look"};
  const FactorTable& widest = table.of_samples.empty() ? table : table.of_samples.front();
  text.columns.insert(text.columns.end(), widest.factors.begin(), widest.factors.end());
  append_rows(table, text);
  for (const FactorTable& samples : table.of_samples) append_rows(samples, text);
  return text;
}

void encode(const FactorTable& table, ByteWriter& writer) { encode_whole(table, writer); }
void decode(ByteReader& reader, FactorTable& table) { decode_whole(reader, table); }

std::size_t RowsOf<FactorTable>::size(const FactorTable& head) {
  std::size_t values = head.values_per_site();
  for (const FactorTable& samples : head.of_samples) values += samples.values_per_site();
  return values * sizeof(double);
}

FactorTable RowsOf<FactorTable>::head_of(const FactorTable& table) {
  return part_of(table, 0, table.site_count);
}

FactorTable RowsOf<FactorTable>::part_of(const FactorTable& head, std::size_t first,
                                         std::size_t count) {
  const auto site_count = static_cast<std::uint32_t>(count);
  FactorTable part{head.looks, head.factors, site_count, head.shared_count, {}, {}};
  for (const FactorTable& samples : head.of_samples) {
    part.of_samples.push_back(part_of(samples, first, count));
  }
  return part;
}

void RowsOf<FactorTable>::resize(FactorTable& head, std::size_t count) {
  head.values.resize(count * head.values_per_site());
  for (FactorTable& samples : head.of_samples) resize(samples, count);
}

void RowsOf<FactorTable>::encode_head(const FactorTable& table, ByteWriter& writer) {
  encode_both(table, writer, encode_own_head);
}

void RowsOf<FactorTable>::decode_head(ByteReader& reader, FactorTable& table) {
  decode_both(reader, table, decode_own_head);
  if (!has_one_site_count(table)) reader.fail();
}

void RowsOf<FactorTable>::encode(const FactorTable& table, std::size_t first, std::size_t count,
                                 ByteWriter& writer) {
  for (std::size_t site = first; site < first + count; ++site) {
    const auto append = [&](std::span<const double> values) {
      writer.append(values.data(), values.size_bytes());
    };
    append(values_of(table, site, 1));
    for (const FactorTable& samples : table.of_samples) append(values_of(samples, site, 1));
  }
}

void RowsOf<FactorTable>::decode(ByteReader& reader, FactorTable& table, std::size_t first,
                                 std::size_t count) {
  for (std::size_t site = first; site < first + count; ++site) {
    for (double& value : values_of(table, site, 1)) reader.get(value);
    for (FactorTable& samples : table.of_samples) {
      for (double& value : values_of(samples, site, 1)) reader.get(value);
    }
  }
}

}  // namespace sightline
