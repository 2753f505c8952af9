#include "passes/localize/measured_parts.h"
#include "formats/tables/stored_table_writer.h"

#include <algorithm>
#include <span>

namespace sightline {
namespace {

// The same without rows and sites.
MeasuredError head_of(MeasuredError measured) {
  measured.rows.clear();
  measured.scan_of_site.clear();
  for (MeasuredError& samples : measured.of_samples) samples = head_of(std::move(samples));
  return measured;
}

// Some sites as an artifact of its own, with rows of zeros.
MeasuredError empty_part(const MeasuredError& head, const std::vector<std::int64_t>& scan_of_site,
                         const std::vector<std::size_t>& sites) {
  MeasuredError part = head;
  for (const std::size_t site : sites) part.scan_of_site.push_back(scan_of_site[site]);
  part.rows.resize(part.shape().size(sites.size()));
  for (MeasuredError& samples : part.of_samples) {
    samples = empty_part(samples, scan_of_site, sites);
  }
  return part;
}

bool is_like(const MeasuredError& part, const MeasuredError& empty) {
  return part.scan_of_site == empty.scan_of_site && part.looks == empty.looks &&
         part.rows.size() == empty.rows.size() &&
         std::ranges::equal(part.of_samples, empty.of_samples, is_like);
}

}  // namespace

Result<StoredTable<MeasuredError>> fill_in_parts(const PassContext& ctx, const MeasuredParts& parts,
                                                 int at_once, const MeasuredError& measured) {
  const MeasuredError head = head_of(measured);
  const auto empty = [&](std::size_t part) {
    return empty_part(head, measured.scan_of_site, parts.sites[part]);
  };
  StoredTableWriter<MeasuredError> writer(measured);
  PartedWork work;
  work.order = parts.order;
  work.count = parts.sites.size();
  work.content = [&](std::size_t part) -> std::optional<Digest> {
    const std::optional<Digest> content = parts.content(part);
    if (!content) return std::nullopt;
    return derived_digest("measured", *content, to_bytes(empty(part)));
  };
  work.make = [&](std::size_t part, int /*threads*/) -> Result<std::vector<std::byte>> {
    MeasuredError rows = empty(part);
    SIGHTLINE_TRY(parts.fill(part, rows));
    return to_bytes(rows);
  };
  work.take = [&](std::size_t part, std::span<const std::byte> bytes) {
    const Result<MeasuredError> rows = from_bytes<MeasuredError>(bytes);
    if (!rows || !is_like(*rows, empty(part))) return false;
    writer.put(parts.sites[part], *rows);
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work, at_once));
  return writer.take();
}

}  // namespace sightline
