#include "formats/annotation/factor_table.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>

#include "formats/annotation/of_samples.h"
#include "formats/base/check.h"

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

}  // namespace

void encode_head(const FactorTable& table, ByteWriter& writer) {
  encode(table.looks, writer);
  writer.put<std::uint64_t>(table.factors.size());
  for (const std::string& factor : table.factors) writer.put_string(factor);
  writer.put(table.site_count);
  writer.put(table.shared_count);
}

void decode_head(ByteReader& reader, FactorTable& table) {
  decode(reader, table.looks);
  table.factors.resize(reader.get_count(sizeof(std::uint64_t)));
  for (std::string& factor : table.factors) reader.get_string(factor);
  reader.get(table.site_count);
  reader.get(table.shared_count);
}

namespace {

void decode_own(ByteReader& reader, FactorTable& table) {
  decode_head(reader, table);
  reader.get_array(table.values);
}

Result<void> visit_own(const FactorTable& table, const ByteSink& sink) {
  ByteWriter head;
  encode_head(table, head);
  head.put<std::uint64_t>(table.values.size());
  SIGHTLINE_TRY(sink(head.bytes()));
  return sink(std::as_bytes(std::span(table.values)));
}

Error undecodable() {
  return {ErrorCode::kBadLayer, "the payload of a factor-table cannot be decoded"};
}

// From `offset` on, which moves behind it.
Result<void> open_own(const StoredBytes& payload, std::uint64_t& offset, FactorTable& table) {
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> count,
                   read_head(payload, offset, table, sizeof(double)));
  if (!count) return undecodable();
  table.values.resize(*count);
  SIGHTLINE_TRY(payload.read(offset, std::as_writable_bytes(std::span(table.values))));
  offset += *count * sizeof(double);
  return {};
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
  const auto append = [&](std::span<const std::byte> piece) -> Result<void> {
    writer.append(piece.data(), piece.size());
    return {};
  };
  const Result<void> written = visit_payload(table, append);
  SIGHTLINE_CHECK(written.has_value());
}

void decode(ByteReader& reader, FactorTable& table) { decode_both(reader, table, decode_own); }

std::uint64_t payload_size(const FactorTable& table) {
  ByteWriter counting = ByteWriter::that_counts();
  encode(table, counting);
  return counting.count();
}

Result<void> visit_payload(const FactorTable& table, const ByteSink& sink) {
  return visit_both(table, sink, visit_own);
}

Result<void> open_payload(const StoredBytes& payload, FactorTable& table) {
  std::uint64_t offset = 0;
  SIGHTLINE_ASSIGN(const bool is_whole, open_both(payload, offset, table, open_own));
  if (!is_whole) return undecodable();
  return validate(table);
}

}  // namespace sightline
