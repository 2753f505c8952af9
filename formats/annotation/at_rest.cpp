#include "formats/annotation/at_rest.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "formats/annotation/of_samples.h"
#include "formats/base/check.h"

// Bytes are those of encode(X): the head of a table, the count of its values, the values, which
// take as many bytes at every site; how many tables of samples follow, and those likewise.

namespace sightline {
namespace {

// What differs between the two kinds of tables. A value is what their encoding counts.
template <class X>
struct Values;

template <>
struct Values<MeasuredError> {
  static constexpr std::size_t kBytes = kEncodedErrorRow;
  static std::size_t site_count(const MeasuredError& table) { return table.scan_of_site.size(); }
  // None where a head makes no sense.
  static std::optional<std::size_t> per_site(const MeasuredError& table) {
    return table.looks.size();
  }
  static MeasuredError head_of(const MeasuredError& all, std::size_t first, std::size_t count) {
    MeasuredError some{all.drive, all.matching, all.reference, all.looks, all.offsets, {}, {}, {}};
    const auto begin = all.scan_of_site.begin() + static_cast<std::ptrdiff_t>(first);
    some.scan_of_site.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
    return some;
  }
  static auto& of(MeasuredError& table) { return table.rows; }
  static auto& of(const MeasuredError& table) { return table.rows; }
  static void encode(std::span<const ErrorRow> rows, ByteWriter& writer) {
    encode_rows(rows, writer);
  }
  static void decode(ByteReader& reader, std::span<ErrorRow> rows) { decode_rows(reader, rows); }
};

template <>
struct Values<FactorTable> {
  static constexpr std::size_t kBytes = sizeof(double);
  static std::size_t site_count(const FactorTable& table) { return table.site_count; }
  static std::optional<std::size_t> per_site(const FactorTable& table) {
    if (table.shared_count > table.factors.size()) return std::nullopt;
    return table.values_per_site();
  }
  static FactorTable head_of(const FactorTable& all, std::size_t /*first*/, std::size_t count) {
    return {all.looks, all.factors, static_cast<std::uint32_t>(count), all.shared_count, {}, {}};
  }
  static auto& of(FactorTable& table) { return table.values; }
  static auto& of(const FactorTable& table) { return table.values; }
  static void encode(std::span<const double> values, ByteWriter& writer) {
    writer.append(values.data(), values.size_bytes());
  }
  static void decode(ByteReader& reader, std::span<double> values) {
    for (double& value : values) reader.get(value);
  }
};

template <class X>
std::size_t bytes_per_site(const X& head) {
  return *Values<X>::per_site(head) * Values<X>::kBytes;
}

template <class X>
X without_rows(const X& table) {
  X head = Values<X>::head_of(table, 0, Values<X>::site_count(table));
  for (const X& samples : table.of_samples) head.of_samples.push_back(without_rows(samples));
  return head;
}

// Own table and table of samples, without each other's.
template <class X>
std::vector<const X*> tables_of(const X& table) {
  std::vector<const X*> tables = {&table};
  for (const X& samples : table.of_samples) tables.push_back(&samples);
  return tables;
}

template <class X>
Error undecodable() {
  return {ErrorCode::kBadLayer,
          "the payload of a " + std::string(ArtifactTraits<X>::kName) + " cannot be decoded"};
}

}  // namespace

template <class X>
AtRest<X>::AtRest(const X& whole) {
  constexpr std::size_t kAllInMemory = std::numeric_limits<std::size_t>::max();
  SiteRowsWriter<X> writer(whole, kAllInMemory);
  writer.put(0, whole);
  Result<AtRest> made = writer.take();
  SIGHTLINE_CHECK(made.has_value());
  *this = *std::move(made);
}

template <class X>
std::size_t AtRest<X>::site_count() const {
  return Values<X>::site_count(head_);
}

namespace {

// Of the table whose rows begin there.
template <class X>
Result<X> read_sites(const StoredBytes& payload, const X& head, std::uint64_t rows_at,
                     std::size_t first, std::size_t count) {
  X some = Values<X>::head_of(head, first, count);
  auto& values = Values<X>::of(some);
  values.resize(count * *Values<X>::per_site(head));
  const std::size_t per_site = *Values<X>::per_site(head);
  for (std::size_t begin = 0; begin < count; begin += kSitesInStretch) {
    const std::size_t here = std::min(kSitesInStretch, count - begin);
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes,
                     payload.read(rows_at + (first + begin) * bytes_per_site(head),
                                  here * bytes_per_site(head)));
    ByteReader reader(bytes);
    Values<X>::decode(reader, std::span(values).subspan(begin * per_site, here * per_site));
    SIGHTLINE_CHECK(reader.at_end());
  }
  return some;
}

}  // namespace

template <class X>
Result<X> AtRest<X>::sites(std::size_t first, std::size_t count) const {
  SIGHTLINE_CHECK(first <= site_count() && count <= site_count() - first);
  SIGHTLINE_ASSIGN(X some, of_ranges(first, count));
  if (!head_.of_samples.empty()) {
    SIGHTLINE_ASSIGN(X samples, of_samples(first, count));
    some.of_samples.push_back(std::move(samples));
  }
  return some;
}

template <class X>
Result<X> AtRest<X>::of_ranges(std::size_t first, std::size_t count) const {
  SIGHTLINE_CHECK(first <= site_count() && count <= site_count() - first);
  if (rows_at_.empty()) return head_;
  return read_sites(payload_, head_, rows_at_.front(), first, count);
}

template <class X>
Result<X> AtRest<X>::of_samples(std::size_t first, std::size_t count) const {
  SIGHTLINE_CHECK(first <= site_count() && count <= site_count() - first);
  SIGHTLINE_CHECK(!head_.of_samples.empty());
  return read_sites(payload_, head_.of_samples.front(), rows_at_.back(), first, count);
}

template <class X>
SiteRowsWriter<X>::SiteRowsWriter(const X& head, std::size_t most_in_memory)
    : bytes_(most_in_memory) {
  made_.head_ = without_rows(head);
  const std::size_t site_count = made_.site_count();
  bool is_first = true;
  for (const X* table : tables_of(made_.head_)) {
    SIGHTLINE_CHECK(Values<X>::per_site(*table) && Values<X>::site_count(*table) == site_count);
    ByteWriter writer;
    if (!is_first) writer.put(static_cast<std::uint8_t>(made_.head_.of_samples.size()));
    is_first = false;
    encode_head(*table, writer);
    writer.put<std::uint64_t>(site_count * *Values<X>::per_site(*table));
    if (written_) written_ = bytes_.append(writer.bytes());
    made_.rows_at_.push_back(bytes_.size());
    const std::vector<std::byte> zeros(kSitesInStretch * bytes_per_site(*table));
    for (std::size_t first = 0; first < site_count && written_; first += kSitesInStretch) {
      const std::size_t here = std::min(kSitesInStretch, site_count - first);
      written_ = bytes_.append(std::span(zeros).first(here * bytes_per_site(*table)));
    }
  }
  constexpr std::byte kNoSamples{0};
  if (written_ && made_.head_.of_samples.empty()) written_ = bytes_.append({&kNoSamples, 1});
}

template <class X>
void SiteRowsWriter<X>::put(std::span<const std::size_t> sites, const X& rows) {
  const std::vector<const X*> own = tables_of(made_.head_);
  const std::vector<const X*> given = tables_of(rows);
  SIGHTLINE_CHECK(own.size() == given.size());
  for (std::size_t table = 0; table < own.size(); ++table) {
    const auto& values = Values<X>::of(*given[table]);
    const std::size_t per_site = *Values<X>::per_site(*own[table]);
    SIGHTLINE_CHECK(values.size() == sites.size() * per_site);
    // Those in a row at once.
    for (std::size_t i = 0; i < sites.size();) {
      std::size_t end = i + 1;
      while (end < sites.size() && sites[end] == sites[end - 1] + 1 && end - i < kSitesInStretch) {
        ++end;
      }
      SIGHTLINE_CHECK(sites[end - 1] < made_.site_count());
      ByteWriter writer;
      Values<X>::encode(std::span(values).subspan(i * per_site, (end - i) * per_site), writer);
      const std::lock_guard<std::mutex> lock(*mutex_);
      if (written_) {
        written_ = bytes_.replace(made_.rows_at_[table] + sites[i] * bytes_per_site(*own[table]),
                                  writer.bytes());
      }
      i = end;
    }
  }
}

template <class X>
void SiteRowsWriter<X>::put(std::size_t first, const X& rows) {
  std::vector<std::size_t> sites(Values<X>::site_count(rows));
  std::iota(sites.begin(), sites.end(), first);
  put(sites, rows);
}

template <class X>
Result<AtRest<X>> SiteRowsWriter<X>::take() {
  SIGHTLINE_TRY(written_);
  made_.payload_ = bytes_.take();
  return std::move(made_);
}

template <class X>
Result<void> validate(const AtRest<X>& table) {
  for (std::size_t first = 0; first == 0 || first < table.site_count(); first += kSitesInStretch) {
    const std::size_t count = std::min(kSitesInStretch, table.site_count() - first);
    SIGHTLINE_ASSIGN(const X some, table.sites(first, count));
    const Result<void> checked = validate(some);
    if (checked) continue;
    Error error = checked.error();
    if (first > 0) error.place = "from site " + std::to_string(first) + " on, " + error.place;
    return error;
  }
  return {};
}

template <class X>
Table dump(const AtRest<X>& table) {
  const Result<X> whole = table.whole();
  SIGHTLINE_CHECK(whole.has_value());
  return dump(*whole);
}

template <class X>
std::uint64_t payload_size(const AtRest<X>& table) {
  return table.payload_.size();
}

template <class X>
Result<void> visit_payload(const AtRest<X>& table, const ByteSink& sink) {
  return table.payload_.visit(sink);
}

template <class X>
Result<void> open_payload(const StoredBytes& payload, AtRest<X>& table) {
  AtRest<X> opened;
  const auto open_own = [&](const StoredBytes& bytes, std::uint64_t& offset,
                            X& head) -> Result<void> {
    SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> count,
                     read_head(bytes, offset, head, Values<X>::kBytes));
    const std::size_t sites = Values<X>::site_count(head);
    const std::optional<std::size_t> per_site = Values<X>::per_site(head);
    const bool is_full =
        count && per_site &&
        (sites == 0 ? *count == 0 : *count % sites == 0 && *count / sites == *per_site);
    if (!is_full) return undecodable<X>();
    opened.rows_at_.push_back(offset);
    offset += *count * Values<X>::kBytes;
    return {};
  };
  std::uint64_t offset = 0;
  SIGHTLINE_ASSIGN(const bool is_whole, open_both(payload, offset, opened.head_, open_own));
  if (!is_whole) return undecodable<X>();
  for (const X& samples : opened.head_.of_samples) {
    if (Values<X>::site_count(samples) != opened.site_count()) return undecodable<X>();
  }
  opened.payload_ = payload;
  SIGHTLINE_TRY(validate(opened));
  table = std::move(opened);
  return {};
}

template class AtRest<MeasuredError>;
template class AtRest<FactorTable>;
template class SiteRowsWriter<MeasuredError>;
template class SiteRowsWriter<FactorTable>;
template Result<void> validate(const AtRest<MeasuredError>&);
template Result<void> validate(const AtRest<FactorTable>&);
template Table dump(const AtRest<MeasuredError>&);
template Table dump(const AtRest<FactorTable>&);
template std::uint64_t payload_size(const AtRest<MeasuredError>&);
template std::uint64_t payload_size(const AtRest<FactorTable>&);
template Result<void> visit_payload(const AtRest<MeasuredError>&, const ByteSink&);
template Result<void> visit_payload(const AtRest<FactorTable>&, const ByteSink&);
template Result<void> open_payload(const StoredBytes&, AtRest<MeasuredError>&);
template Result<void> open_payload(const StoredBytes&, AtRest<FactorTable>&);

}  // namespace sightline
