#include "formats/annotation/measured_error.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "formats/record/fields.h"

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
constexpr std::size_t kEncodedRow = std::size(kRowFields) * sizeof(double) + sizeof(std::uint32_t);

Result<void> validate_setup(const MeasuredError& measured) {
  if (name_of(measured.reference).empty()) {
    return invalid_artifact("found an unknown reference", "");
  }
  SIGHTLINE_TRY(validate(measured.matching.localizer));
  if (measured.matching.site_step == 0) return invalid_artifact("found a step of 0 sites", "");
  SIGHTLINE_TRY(validate(measured.looks));
  for (std::size_t i = 0; i < measured.offsets.size(); ++i) {
    if (!are_finite(measured.offsets[i])) {
      return invalid_artifact("found an offset that is not finite", concat("offset ", i));
    }
  }
  if (measured.rows.size() != measured.shape().size(measured.scan_of_site.size())) {
    return invalid_artifact(
        concat("found ", measured.rows.size(), " rows for ", measured.scan_of_site.size(),
               " sites and ", measured.looks.size(), " looks"),
        "");
  }
  return {};
}

Result<void> validate_row(const ErrorRow& row, bool has_scan, const std::string& place) {
  bool is_zero = row.point_count == 0;
  for (const RowField& field : kRowFields) {
    const double value = row.*field.value;
    if (!std::isfinite(value) || value < 0.0) {
      return invalid_artifact(concat("found ", field.name, " = ", format_double(value),
                                     ", expected a finite number of at least 0"),
                              place);
    }
    is_zero = is_zero && value == 0.0;
  }
  if (!has_scan && !is_zero) {
    return invalid_artifact("found a result where no scan was matched", place);
  }
  if (row.lost_share > 1.0) {
    return invalid_artifact(
        concat("found lost_share = ", format_double(row.lost_share), ", expected at most 1"),
        place);
  }
  return {};
}

void encode_row(const ErrorRow& row, ByteWriter& writer) {
  writer.put(row.point_count);
  for (const RowField& field : kRowFields) writer.put(row.*field.value);
}

void decode_row(ByteReader& reader, ErrorRow& row) {
  reader.get(row.point_count);
  for (const RowField& field : kRowFields) reader.get(row.*field.value);
}

// The rows of one site.
template <class Measured>
auto rows_at(Measured& measured, std::size_t site) {
  return std::span(measured.rows).subspan(site * measured.looks.size(), measured.looks.size());
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
  SIGHTLINE_TRY(validate_setup(measured));
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    if (measured.scan_of_site[site] < -1) {
      return invalid_artifact(
          concat("found scan ", measured.scan_of_site[site], ", expected an index or -1"),
          concat("site ", site));
    }
    for (std::size_t range = 0; range < measured.looks.size(); ++range) {
      SIGHTLINE_TRY(validate_row(measured.row(site, range), measured.scan_of_site[site] >= 0,
                                 concat("site ", site, ", range ", range)));
    }
  }
  return {};
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
    const std::string name = concat("offset_", k, "_");
    table.facts.emplace_back(name + "x_m", measured.offsets[k].x_m);
    table.facts.emplace_back(name + "y_m", measured.offsets[k].y_m);
    table.facts.emplace_back(name + "z_m", measured.offsets[k].z_m);
    table.facts.emplace_back(name + "yaw_rad", measured.offsets[k].yaw_rad);
  }
  table.columns = {"site", "range_m", "look", "scan", "point_count"};
  for (const RowField& field : kRowFields) table.columns.emplace_back(field.name);
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
  return table;
}

void encode(const MeasuredError& measured, ByteWriter& writer) { encode_whole(measured, writer); }
void decode(ByteReader& reader, MeasuredError& measured) { decode_whole(reader, measured); }

std::size_t RowsOf<MeasuredError>::size(const MeasuredError& head) {
  return head.looks.size() * kEncodedRow;
}

MeasuredError RowsOf<MeasuredError>::head_of(const MeasuredError& table) {
  return part_of(table, 0, table.scan_of_site.size());
}

MeasuredError RowsOf<MeasuredError>::part_of(const MeasuredError& head, std::size_t first,
                                             std::size_t count) {
  MeasuredError part{head.drive, head.matching, head.reference, head.looks, head.offsets, {}, {}};
  const auto scans = std::span(head.scan_of_site).subspan(first, count);
  part.scan_of_site.assign(scans.begin(), scans.end());
  return part;
}

void RowsOf<MeasuredError>::resize(MeasuredError& head, std::size_t count) {
  head.rows.resize(head.shape().size(count));
}

void RowsOf<MeasuredError>::encode_head(const MeasuredError& table, ByteWriter& writer) {
  writer.put_string(table.drive);
  writer.put(table.matching.scans);
  sightline::encode(table.matching.localizer, writer);
  writer.put(table.matching.coarse_cells);
  writer.put(table.matching.leaf_m);
  writer.put(table.matching.site_step);
  writer.put(table.reference);
  sightline::encode(table.looks, writer);
  sightline::encode(table.offsets, writer);
  writer.put_array(table.scan_of_site);
}

void RowsOf<MeasuredError>::decode_head(ByteReader& reader, MeasuredError& table) {
  reader.get_string(table.drive);
  reader.get(table.matching.scans);
  sightline::decode(reader, table.matching.localizer);
  reader.get(table.matching.coarse_cells);
  reader.get(table.matching.leaf_m);
  reader.get(table.matching.site_step);
  reader.get(table.reference);
  sightline::decode(reader, table.looks);
  sightline::decode(reader, table.offsets);
  reader.get_array(table.scan_of_site);
}

void RowsOf<MeasuredError>::encode(const MeasuredError& table, std::size_t first, std::size_t count,
                                   ByteWriter& writer) {
  for (std::size_t site = first; site < first + count; ++site) {
    for (const ErrorRow& row : rows_at(table, site)) encode_row(row, writer);
  }
}

void RowsOf<MeasuredError>::decode(ByteReader& reader, MeasuredError& table, std::size_t first,
                                   std::size_t count) {
  for (std::size_t site = first; site < first + count; ++site) {
    for (ErrorRow& row : rows_at(table, site)) decode_row(reader, row);
  }
}

}  // namespace sightline
