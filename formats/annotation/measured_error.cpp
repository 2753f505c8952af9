#include "formats/annotation/measured_error.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "formats/annotation/of_samples.h"
#include "formats/record/finite.h"

namespace sightline {
namespace {

// The numbers of a row but point_count, with the names they are printed under, in the order of dump
// and encoding.
struct RowField {
  const char* name;
  double ErrorRow::*value;
};
constexpr RowField kRowFields[] = {{"mean_m", &ErrorRow::mean_m},
                                   {"median_m", &ErrorRow::median_m},
                                   {"p90_m", &ErrorRow::p90_m},
                                   {"max_m", &ErrorRow::max_m},
                                   {"longitudinal_m", &ErrorRow::longitudinal_m},
                                   {"lateral_m", &ErrorRow::lateral_m},
                                   {"yaw_rad", &ErrorRow::yaw_rad},
                                   {"lost_share", &ErrorRow::lost_share},
                                   {"from_given_m", &ErrorRow::from_given_m},
                                   {"mean_iterations", &ErrorRow::mean_iterations},
                                   {"mean_work", &ErrorRow::mean_work},
                                   {"max_work", &ErrorRow::max_work},
                                   {"mean_time_ms", &ErrorRow::mean_time_ms},
                                   {"max_time_ms", &ErrorRow::max_time_ms}};
static_assert(std::size(kRowFields) * sizeof(double) + sizeof(std::uint32_t) == kEncodedErrorRow);

Result<void> validate_setup(const MeasuredError& measured) {
  if (name_of(measured.reference).empty()) {
    return invalid_artifact("found an unknown reference", "");
  }
  SIGHTLINE_TRY(validate(measured.matching.localizer));
  if (measured.matching.site_step == 0) return invalid_artifact("found a step of 0 sites", "");
  SIGHTLINE_TRY(validate(measured.looks));
  for (std::size_t i = 0; i < measured.offsets.size(); ++i) {
    if (!are_finite(measured.offsets[i])) {
      return invalid_artifact("found an offset that is not finite", "offset " + std::to_string(i));
    }
  }
  if (measured.rows.size() != measured.shape().size(measured.scan_of_site.size())) {
    return invalid_artifact("found " + std::to_string(measured.rows.size()) + " rows for " +
                                std::to_string(measured.scan_of_site.size()) + " sites and " +
                                std::to_string(measured.looks.size()) + " looks",
                            "");
  }
  return {};
}

Result<void> validate_row(const ErrorRow& row, bool has_scan, const std::string& place) {
  bool is_zero = row.point_count == 0;
  for (const RowField& field : kRowFields) {
    const double value = row.*field.value;
    if (!std::isfinite(value) || value < 0.0) {
      return invalid_artifact(std::string("found ") + field.name + " = " + format_double(value) +
                                  ", expected a finite number that is not negative",
                              place);
    }
    is_zero = is_zero && value == 0.0;
  }
  if (!has_scan && !is_zero) {
    return invalid_artifact("found a result where no scan was matched", place);
  }
  if (row.lost_share > 1.0) {
    return invalid_artifact(
        "found lost_share = " + format_double(row.lost_share) + ", expected at most 1", place);
  }
  return {};
}

Result<void> validate_own(const MeasuredError& measured) {
  SIGHTLINE_TRY(validate_setup(measured));
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    if (measured.scan_of_site[site] < -1) {
      return invalid_artifact(
          "found scan " + std::to_string(measured.scan_of_site[site]) + ", expected an index or -1",
          "site " + std::to_string(site));
    }
    for (std::size_t range = 0; range < measured.looks.size(); ++range) {
      SIGHTLINE_TRY(
          validate_row(measured.row(site, range), measured.scan_of_site[site] >= 0,
                       "site " + std::to_string(site) + ", range " + std::to_string(range)));
    }
  }
  return {};
}

const std::vector<Look>& looks_of(const MeasuredError& measured) { return measured.looks; }

}  // namespace

void encode_head(const MeasuredError& measured, ByteWriter& writer) {
  writer.put_string(measured.drive);
  writer.put(measured.matching.scans);
  encode(measured.matching.localizer, writer);
  writer.put(measured.matching.coarse_cells);
  writer.put(measured.matching.leaf_m);
  writer.put(measured.matching.site_step);
  writer.put(measured.reference);
  encode(measured.looks, writer);
  encode(measured.offsets, writer);
  writer.put_array(measured.scan_of_site);
}

void decode_head(ByteReader& reader, MeasuredError& measured) {
  reader.get_string(measured.drive);
  reader.get(measured.matching.scans);
  decode(reader, measured.matching.localizer);
  reader.get(measured.matching.coarse_cells);
  reader.get(measured.matching.leaf_m);
  reader.get(measured.matching.site_step);
  reader.get(measured.reference);
  decode(reader, measured.looks);
  decode(reader, measured.offsets);
  reader.get_array(measured.scan_of_site);
}

void encode_rows(std::span<const ErrorRow> rows, ByteWriter& writer) {
  for (const ErrorRow& row : rows) {
    writer.put(row.point_count);
    for (const RowField& field : kRowFields) writer.put(row.*field.value);
  }
}

void decode_rows(ByteReader& reader, std::span<ErrorRow> rows) {
  for (ErrorRow& row : rows) {
    reader.get(row.point_count);
    for (const RowField& field : kRowFields) reader.get(row.*field.value);
  }
}

namespace {

void encode_own(const MeasuredError& measured, ByteWriter& writer) {
  encode_head(measured, writer);
  writer.put<std::uint64_t>(measured.rows.size());
  encode_rows(measured.rows, writer);
}

void decode_own(ByteReader& reader, MeasuredError& measured) {
  decode_head(reader, measured);
  measured.rows.resize(reader.get_count(kEncodedErrorRow));
  decode_rows(reader, measured.rows);
}

// Rows that are taken through bytes at once.
constexpr std::size_t kRowsInPiece = 4096;

Result<void> visit_own(const MeasuredError& measured, const ByteSink& sink) {
  ByteWriter head;
  encode_head(measured, head);
  head.put<std::uint64_t>(measured.rows.size());
  SIGHTLINE_TRY(sink(head.bytes()));
  const std::span<const ErrorRow> rows(measured.rows);
  for (std::size_t first = 0; first < rows.size(); first += kRowsInPiece) {
    ByteWriter piece;
    encode_rows(rows.subspan(first, std::min(kRowsInPiece, rows.size() - first)), piece);
    SIGHTLINE_TRY(sink(piece.bytes()));
  }
  return {};
}

Error undecodable() {
  return {ErrorCode::kBadLayer, "the payload of a measured-error cannot be decoded"};
}

// From `offset` on, which moves behind it.
Result<void> open_own(const StoredBytes& payload, std::uint64_t& offset, MeasuredError& measured) {
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> count,
                   read_head(payload, offset, measured, kEncodedErrorRow));
  if (!count) return undecodable();
  measured.rows.resize(*count);
  const std::span<ErrorRow> rows(measured.rows);
  for (std::size_t first = 0; first < rows.size(); first += kRowsInPiece) {
    const auto some = rows.subspan(first, std::min(kRowsInPiece, rows.size() - first));
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                     payload.read(offset, some.size() * kEncodedErrorRow));
    ByteReader reader(bytes);
    decode_rows(reader, some);
    offset += bytes.size();
  }
  return {};
}

void append_rows(const MeasuredError& measured, Table& table) {
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    for (std::size_t look = 0; look < measured.looks.size(); ++look) {
      const ErrorRow& row = measured.row(site, look);
      std::vector<Cell> cells = {static_cast<std::int64_t>(site), measured.looks[look].range_m,
                                 to_text(measured.looks[look]), measured.scan_of_site[site],
                                 std::int64_t{row.point_count}};
      for (const RowField& field : kRowFields) cells.emplace_back(row.*field.value);
      table.rows.push_back(std::move(cells));
    }
  }
}

}  // namespace

std::string_view reference_text(ErrorReference reference) {
  switch (reference) {
    case ErrorReference::kKnownPose:
      return "known poses";
    case ErrorReference::kFullRangeMatch:
      return "the match at full range";
    case ErrorReference::kSimulated:
      return "the places of simulated scans";
  }
  return "";
}

Result<void> validate(const MeasuredError& measured) {
  return validate_both(measured, validate_own, looks_of);
}

Table dump(const MeasuredError& measured) {
  Table table;
  table.name = "measured";
  table.facts.emplace_back("drive", measured.drive);
  table.facts.emplace_back("scans", std::string(name_of(measured.matching.scans)));
  table.facts.emplace_back("localizer", measured.matching.localizer.name);
  table.facts.emplace_back("localizer_version", std::int64_t{measured.matching.localizer.version});
  table.facts.emplace_back("localizer_parameters", parameters_text(measured.matching.localizer));
  table.facts.emplace_back("coarse_cells", std::int64_t{measured.matching.coarse_cells});
  table.facts.emplace_back("leaf_m", measured.matching.leaf_m);
  table.facts.emplace_back("site_step", std::int64_t{measured.matching.site_step});
  table.facts.emplace_back("reference", std::string(name_of(measured.reference)));
  table.facts.emplace_back("offset_count", static_cast<std::int64_t>(measured.offsets.size()));
  for (std::size_t k = 0; k < measured.offsets.size(); ++k) {
    const std::string name = "offset_" + std::to_string(k) + "_";
    table.facts.emplace_back(name + "x_m", measured.offsets[k].x_m);
    table.facts.emplace_back(name + "y_m", measured.offsets[k].y_m);
    table.facts.emplace_back(name + "z_m", measured.offsets[k].z_m);
    table.facts.emplace_back(name + "yaw_rad", measured.offsets[k].yaw_rad);
  }
  table.columns = {"site", "range_m", "look", "scan", "point_count"};
  for (const RowField& field : kRowFields) table.columns.emplace_back(field.name);
  append_rows(measured, table);
  for (const MeasuredError& samples : measured.of_samples) append_rows(samples, table);
  return table;
}

void encode(const MeasuredError& measured, ByteWriter& writer) {
  encode_both(measured, writer, encode_own);
}

void decode(ByteReader& reader, MeasuredError& measured) {
  decode_both(reader, measured, decode_own);
}

std::uint64_t payload_size(const MeasuredError& measured) {
  ByteWriter counting = ByteWriter::that_counts();
  encode(measured, counting);
  return counting.count();
}

Result<void> visit_payload(const MeasuredError& measured, const ByteSink& sink) {
  return visit_both(measured, sink, visit_own);
}

Result<void> open_payload(const StoredBytes& payload, MeasuredError& measured) {
  std::uint64_t offset = 0;
  SIGHTLINE_ASSIGN(const bool is_whole, open_both(payload, offset, measured, open_own));
  if (!is_whole) return undecodable();
  return validate(measured);
}

}  // namespace sightline
