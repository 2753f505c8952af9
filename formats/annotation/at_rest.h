#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/base/files/stored_bytes.h"

namespace sightline {

template <class X>
class SiteRowsWriter;

// A table of sites, X = MeasuredError or FactorTable, whose rows stay encoded and are read some
// sites at a time, so that a street of any length takes no more memory than a stretch of it. The
// same bytes as X's. Safe from several threads.
template <class X>
class AtRest {
 public:
  AtRest() = default;
  // Who has a table whole may hand it over where one at rest is taken: it stays in memory.
  AtRest(const X& whole);  // NOLINT(google-explicit-constructor)

  // All but the rows; of the table of samples too.
  [[nodiscard]] const X& head() const { return head_; }
  [[nodiscard]] std::size_t site_count() const;

  // Some sites in a row, within what there is, as a table of their own. Error: cannot-read, as of
  // all that follow.
  [[nodiscard]] Result<X> sites(std::size_t first, std::size_t count) const;
  [[nodiscard]] Result<X> whole() const { return sites(0, site_count()); }
  // The same by the looks that take every return alone, and by those that do not, which there are.
  [[nodiscard]] Result<X> of_ranges(std::size_t first, std::size_t count) const;
  [[nodiscard]] Result<X> of_samples(std::size_t first, std::size_t count) const;

 private:
  friend class SiteRowsWriter<X>;
  template <class Y>
  friend std::uint64_t payload_size(const AtRest<Y>& table);
  template <class Y>
  friend Result<void> visit_payload(const AtRest<Y>& table, const ByteSink& sink);
  template <class Y>
  friend Result<void> open_payload(const StoredBytes& payload, AtRest<Y>& table);

  X head_;
  std::vector<std::uint64_t> rows_at_;  // within the payload: own, of the table of samples
  StoredBytes payload_;
};

// Makes a table at rest, some sites at a time, in any order.
template <class X>
class SiteRowsWriter {
 public:
  // In memory as far as they are few: a kilometre or two.
  static constexpr std::size_t kMostInMemory = std::size_t{4} << 20;
  // `head`: all but the rows. What is not put is zero.
  explicit SiteRowsWriter(const X& head, std::size_t most_in_memory = kMostInMemory);

  // The rows of a table of these sites, in their order. Safe from several threads. A failure is
  // told by take().
  void put(std::span<const std::size_t> sites, const X& rows);
  // Of consecutive sites.
  void put(std::size_t first, const X& rows);
  // All, once. Errors: disk-full, cannot-write.
  [[nodiscard]] Result<AtRest<X>> take();

 private:
  AtRest<X> made_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  GrowingBytes bytes_;
  Result<void> written_;
};

extern template class AtRest<MeasuredError>;
extern template class AtRest<FactorTable>;
extern template class SiteRowsWriter<MeasuredError>;
extern template class SiteRowsWriter<FactorTable>;

// Sites that a pass takes through its memory at once.
inline constexpr std::size_t kSitesInStretch = 256;

// A form of X.
template <class X>
struct ArtifactTraits<AtRest<X>> {
  using Artifact = X;
  static constexpr std::string_view kName = ArtifactTraits<X>::kName;
  static constexpr std::uint32_t kVersion = ArtifactTraits<X>::kVersion;
};

// Reads all sites, stretch by stretch.
template <class X>
Result<void> validate(const AtRest<X>& table);
template <class X>
Table dump(const AtRest<X>& table);

template <class X>
std::uint64_t payload_size(const AtRest<X>& table);
template <class X>
Result<void> visit_payload(const AtRest<X>& table, const ByteSink& sink);
template <class X>
Result<void> open_payload(const StoredBytes& payload, AtRest<X>& table);

}  // namespace sightline
