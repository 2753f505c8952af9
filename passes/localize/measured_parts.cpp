#include "passes/localize/measured_parts.h"
#include "formats/tables/stored_table_writer.h"

#include <algorithm>
#include <span>

namespace sightline {
namespace {

// Without rows and sites.
ByFamily<MeasuredError> head_of(ByFamily<MeasuredError> measured) {
  visit_families(measured, [](MeasuredError& of_family) {
    of_family.rows.clear();
    of_family.tracking_ends.clear();
    of_family.scan_of_site.clear();
  });
  return measured;
}

// Some sites as an artifact of its own, with rows of zeros.
ByFamily<MeasuredError> empty_part(const ByFamily<MeasuredError>& head,
                                   const std::vector<std::int64_t>& scan_of_site,
                                   const std::vector<std::size_t>& sites) {
  ByFamily<MeasuredError> part = head;
  visit_families(part, [&](MeasuredError& of_family) {
    for (const std::size_t site : sites) of_family.scan_of_site.push_back(scan_of_site[site]);
    RowsOf<MeasuredError>::resize(of_family, sites.size());
  });
  return part;
}

bool is_like(const MeasuredError& part, const MeasuredError& empty) {
  return part.scan_of_site == empty.scan_of_site && part.looks == empty.looks &&
         part.rows.size() == empty.rows.size() &&
         part.tracking_ends.size() == empty.tracking_ends.size();
}

bool is_like(const ByFamily<MeasuredError>& part, const ByFamily<MeasuredError>& empty) {
  return is_like(part.ranges, empty.ranges) &&
         part.samples.has_value() == empty.samples.has_value() &&
         (!part.samples || is_like(*part.samples, *empty.samples));
}

}  // namespace

Result<ByFamily<StoredTable<MeasuredError>>> fill_in_parts(
    const PassContext& ctx, const MeasuredParts& parts, int at_once,
    const ByFamily<MeasuredError>& measured) {
  const ByFamily<MeasuredError> head = head_of(measured);
  const auto empty = [&](std::size_t part) {
    return empty_part(head, measured.ranges.scan_of_site, parts.sites[part]);
  };
  StoredTableWriter<MeasuredError> ranges(measured.ranges);
  std::optional<StoredTableWriter<MeasuredError>> samples;
  if (measured.samples) samples.emplace(*measured.samples);
  PartedWork work;
  work.order = parts.order;
  work.count = parts.sites.size();
  work.content = [&](std::size_t part) -> std::optional<Digest> {
    const std::optional<Digest> content = parts.content(part);
    if (!content) return std::nullopt;
    return derived_digest("measured", *content, to_bytes(empty(part)));
  };
  work.make = [&](std::size_t part, int /*threads*/) -> Result<std::vector<std::byte>> {
    ByFamily<MeasuredError> rows = empty(part);
    SIGHTLINE_TRY(parts.fill(part, rows));
    return to_bytes(rows);
  };
  work.take = [&](std::size_t part, std::span<const std::byte> bytes) {
    const Result<ByFamily<MeasuredError>> rows = from_bytes<ByFamily<MeasuredError>>(bytes);
    if (!rows || !is_like(*rows, empty(part))) return false;
    ranges.put(parts.sites[part], rows->ranges);
    if (samples) samples->put(parts.sites[part], *rows->samples);
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work, at_once));
  ByFamily<StoredTable<MeasuredError>> made;
  SIGHTLINE_ASSIGN(made.ranges, ranges.take());
  if (samples) {
    SIGHTLINE_ASSIGN(made.samples, samples->take());
  }
  return made;
}

}  // namespace sightline
