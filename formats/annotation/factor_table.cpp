#include "formats/annotation/factor_table.h"

#include <algorithm>

#include <cmath>
#include <set>

#include "formats/annotation/of_samples.h"

namespace sightline {
namespace {

Error invalid(std::string message, std::string place) {
  return {ErrorCode::kInvalidArtifact, std::move(message), "", std::move(place)};
}

Result<void> validate_own(const FactorTable& table) {
  SIGHTLINE_TRY(validate(table.looks));
  if (table.factors.empty()) return invalid("a factor table needs factors", "");
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

const std::vector<Look>& looks_of(const FactorTable& table) { return table.looks; }

void encode_own(const FactorTable& table, ByteWriter& writer) {
  encode(table.looks, writer);
  writer.put<std::uint64_t>(table.factors.size());
  for (const std::string& factor : table.factors) writer.put_string(factor);
  writer.put(table.site_count);
  writer.put_array(table.values);
}

void decode_own(ByteReader& reader, FactorTable& table) {
  decode(reader, table.looks);
  table.factors.resize(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& factor : table.factors) reader.get_string(factor);
  reader.get(table.site_count);
  reader.get_array(table.values);
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
  return validate_both(table, validate_own, looks_of);
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

void encode(const FactorTable& table, ByteWriter& writer) {
  encode_both(table, writer, encode_own);
}

void decode(ByteReader& reader, FactorTable& table) { decode_both(reader, table, decode_own); }

}  // namespace sightline
