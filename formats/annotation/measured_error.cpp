#include "formats/annotation/measured_error.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>

#include "formats/record/cells.h"
#include "formats/record/codec.h"

namespace sightline {
namespace {

// Of the encoding.
std::size_t row_size() {
  static const std::size_t kSize = written(ErrorRow()).bytes().size();
  return kSize;
}

// Calls use(name, number) for each number of a row but point_count and those by direction.
template <class Use>
void visit_numbers(const ErrorRow& row, const Use& use) {
  const auto visit = [&]<class T>(std::string_view name, const T& value) {
    if constexpr (std::is_same_v<T, double>) use(name, value);
  };
  fields(visit, row);
}

Result<void> validate_offsets(const std::vector<InitialOffset>& offsets, std::string_view name) {
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (!are_finite(offsets[i])) {
      return invalid_artifact("found an offset that is not finite", concat(name, i));
    }
  }
  return {};
}

Result<void> validate_setup(const MeasuredError& measured) {
  if (name_of(measured.reference).empty()) {
    return invalid_artifact("found an unknown reference", "");
  }
  SIGHTLINE_TRY(validate(measured.matching.localizer));
  if (measured.matching.site_step == 0) return invalid_artifact("found a step of 0 sites", "");
  SIGHTLINE_TRY(validate(measured.looks));
  SIGHTLINE_TRY(validate_offsets(measured.offsets, "offset "));
  SIGHTLINE_TRY(validate_offsets(measured.tracking_offsets, "tracking offset "));
  if (measured.rows.size() != measured.shape().size(measured.scan_of_site.size())) {
    return invalid_artifact(
        concat("found ", measured.rows.size(), " rows for ", measured.scan_of_site.size(),
               " sites and ", measured.looks.size(), " looks"),
        "");
  }
  if (measured.tracking_ends.size() != measured.rows.size() * measured.tracking_offsets.size()) {
    return invalid_artifact(concat("found ", measured.tracking_ends.size(), " ends of ",
                                   measured.tracking_offsets.size(), " tracking starts for ",
                                   measured.rows.size(), " rows"),
                            "");
  }
  return {};
}

// The directions of a row and its 3D errors are of the same runs.
Result<void> validate_directions(const ErrorRow& row, const std::string& place) {
  const auto& [mean, deviation, kept] = row.directions;
  if (!are_finite(row.directions)) {
    return invalid_artifact("found an error by direction that is not finite", place);
  }
  constexpr double kRounding = 1e-5;  // of floats, m and rad
  const auto agree = [&](double value, double within) -> bool {
    return std::abs(value) <= within + kRounding * (1.0 + within);
  };
  const bool is_consistent =
      std::min({deviation.longitudinal_m, deviation.lateral_m, deviation.height_m,
                deviation.yaw_rad}) >= 0.0F &&
      agree(double{mean.longitudinal_m}, row.longitudinal_m) &&
      agree(double{mean.lateral_m}, row.lateral_m) && agree(double{mean.yaw_rad}, row.yaw_rad) &&
      agree(std::max({double{deviation.longitudinal_m}, double{deviation.lateral_m},
                      double{deviation.height_m}, std::abs(double{mean.height_m})}),
            row.max_m);
  if (is_consistent) return {};
  return invalid_artifact("found errors by direction that contradict those of the row", place);
}

Result<void> validate_row(const ErrorRow& row, const std::string& place) {
  Result<void> checked;
  visit_numbers(row, [&](std::string_view name, double value) {
    if (!checked || (std::isfinite(value) && value >= 0.0)) return;
    checked = invalid_artifact(concat("found ", name, " = ", format_double(value),
                                      ", expected a finite number of at least 0"),
                               place);
  });
  SIGHTLINE_TRY(checked);
  if (row.lost_share > 1.0) {
    return invalid_artifact(
        concat("found lost_share = ", format_double(row.lost_share), ", expected at most 1"),
        place);
  }
  return validate_directions(row, place);
}

// The rows of one site, and the ends of their tracking starts.
template <class Measured>
auto rows_at(Measured& measured, std::size_t site) {
  return std::span(measured.rows).subspan(site * measured.looks.size(), measured.looks.size());
}
template <class Measured>
auto ends_at(Measured& measured, std::size_t site) {
  const std::size_t count = measured.looks.size() * measured.tracking_offsets.size();
  return std::span(measured.tracking_ends).subspan(site * count, count);
}

// A row of zeros where no scan was matched.
Result<void> validate_site(const MeasuredError& measured, std::size_t site) {
  if (measured.scan_of_site[site] < -1) {
    return invalid_artifact(
        concat("found scan ", measured.scan_of_site[site], ", expected an index or -1"),
        concat("site ", site));
  }
  const bool has_scan = measured.scan_of_site[site] >= 0;
  for (std::size_t look = 0; look < measured.looks.size(); ++look) {
    const std::string place = concat("site ", site, ", range ", look);
    const ErrorRow& row = measured.row(site, look);
    SIGHTLINE_TRY(validate_row(row, place));
    const std::span<const AxisErrors> tracking = measured.tracking(site, look);
    if (!std::ranges::all_of(tracking, are_finite<AxisErrors>)) {
      return invalid_artifact("found an end of a tracking start that is not finite", place);
    }
    if (has_scan) continue;
    const bool is_zero =
        std::ranges::equal(written(row).bytes(), written(ErrorRow()).bytes()) &&
        std::ranges::all_of(tracking, [](const AxisErrors& end) { return end == AxisErrors(); });
    if (!is_zero) {
      return invalid_artifact("found a result where no scan was matched", place);
    }
  }
  return {};
}

// "tracking_mean_longitudinal_m", ..
template <class Use>
void visit_directions(const DirectionErrors& errors, const std::string& prefix, const Use& use) {
  const auto visit = [&](std::string_view figure, const AxisErrors& axes) {
    visit_cells(axes, [&](const std::string& axis, const Cell& cell) {
      use(concat(prefix, figure, "_", axis), cell);
    });
  };
  fields(visit, errors);
}

// Calls use(name, cell) for all of a row and its tracking starts.
template <class Use>
void visit_row(const MeasuredError& measured, const ErrorRow& row,
               std::span<const AxisErrors> tracking, const Use& use) {
  use("point_count", Cell(std::int64_t{row.point_count}));
  visit_numbers(row, [&](std::string_view name, double value) { use(std::string(name), value); });
  visit_directions(row.directions, "", use);
  visit_directions(direction_errors(measured.tracking_offsets, tracking), "tracking_", use);
}

void append_offsets(const std::vector<InitialOffset>& offsets, const std::string& prefix,
                    Table& table) {
  table.facts.emplace_back(prefix + "count", static_cast<std::int64_t>(offsets.size()));
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    append_facts(offsets[k], table, concat(prefix, k, "_"));
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

double tracking_error_m(const MeasuredError& measured, std::size_t site, std::size_t look) {
  const std::span<const AxisErrors> ends = measured.tracking(site, look);
  double squares_m2 = 0.0;
  for (const AxisErrors& end : ends) {
    for (const float axis_m : {end.longitudinal_m, end.lateral_m, end.height_m}) {
      squares_m2 += double{axis_m} * double{axis_m};
    }
  }
  return ends.empty() ? 0.0 : std::sqrt(squares_m2 / static_cast<double>(ends.size()));
}

Result<void> validate(const MeasuredError& measured) {
  SIGHTLINE_TRY(validate_setup(measured));
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    SIGHTLINE_TRY(validate_site(measured, site));
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
  append_offsets(measured.offsets, "offset_", table);
  append_offsets(measured.tracking_offsets, "tracking_offset_", table);
  table.columns = {"site", "range_m", "look", "scan"};
  const std::vector<AxisErrors> none(measured.tracking_offsets.size());
  visit_row(measured, ErrorRow(), none,
            [&](const std::string& name, const Cell&) { table.columns.push_back(name); });
  for (std::size_t site = 0; site < measured.scan_of_site.size(); ++site) {
    for (std::size_t look = 0; look < measured.looks.size(); ++look) {
      std::vector<Cell> cells = {static_cast<std::int64_t>(site), measured.looks[look].range_m,
                                 to_text(measured.looks[look]), measured.scan_of_site[site]};
      visit_row(measured, measured.row(site, look), measured.tracking(site, look),
                [&](const std::string&, const Cell& cell) { cells.push_back(cell); });
      table.rows.push_back(std::move(cells));
    }
  }
  return table;
}

void encode(const MeasuredError& measured, ByteWriter& writer) { encode_whole(measured, writer); }
void decode(ByteReader& reader, MeasuredError& measured) { decode_whole(reader, measured); }

std::size_t RowsOf<MeasuredError>::size(const MeasuredError& head) {
  return head.looks.size() * (row_size() + head.tracking_offsets.size() * sizeof(AxisErrors));
}

MeasuredError RowsOf<MeasuredError>::head_of(const MeasuredError& table) {
  return part_of(table, 0, table.scan_of_site.size());
}

MeasuredError RowsOf<MeasuredError>::part_of(const MeasuredError& head, std::size_t first,
                                             std::size_t count) {
  MeasuredError part;
  part.drive = head.drive;
  part.matching = head.matching;
  part.reference = head.reference;
  part.looks = head.looks;
  part.offsets = head.offsets;
  part.tracking_offsets = head.tracking_offsets;
  const auto scans = std::span(head.scan_of_site).subspan(first, count);
  part.scan_of_site.assign(scans.begin(), scans.end());
  return part;
}

void RowsOf<MeasuredError>::resize(MeasuredError& head, std::size_t count) {
  head.rows.resize(head.shape().size(count));
  head.tracking_ends.resize(head.rows.size() * head.tracking_offsets.size());
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
  sightline::encode(table.tracking_offsets, writer);
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
  sightline::decode(reader, table.tracking_offsets);
  reader.get_array(table.scan_of_site);
}

void RowsOf<MeasuredError>::encode(const MeasuredError& table, std::size_t first, std::size_t count,
                                   ByteWriter& writer) {
  for (std::size_t site = first; site < first + count; ++site) {
    for (const ErrorRow& row : rows_at(table, site)) sightline::encode(row, writer);
    for (const AxisErrors& end : ends_at(table, site)) sightline::encode(end, writer);
  }
}

void RowsOf<MeasuredError>::decode(ByteReader& reader, MeasuredError& table, std::size_t first,
                                   std::size_t count) {
  for (std::size_t site = first; site < first + count; ++site) {
    for (ErrorRow& row : rows_at(table, site)) sightline::decode(reader, row);
    for (AxisErrors& end : ends_at(table, site)) sightline::decode(reader, end);
  }
}

}  // namespace sightline
