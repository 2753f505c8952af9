#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/tables/stored_table.h"

// Looks are of one of two families: those that take every return within a range, the paper's
// observation ranges, and those that take a sample of the returns. A table, choice or model is of
// the looks of one family; ByFamily has that of each.

namespace sightline {

// Of the same sites and drives.
template <class X>
struct ByFamily {
  X ranges;
  std::optional<X> samples;  // none where a localizer takes no samples

  ByFamily() = default;
  // Converts implicitly from ranges alone, and from other forms of an X.
  template <std::convertible_to<X> Y>
  ByFamily(Y&& of_ranges, std::optional<X> of_samples = {})  // NOLINT(google-explicit-constructor)
      : ranges(std::forward<Y>(of_ranges)), samples(std::move(of_samples)) {}
  template <std::convertible_to<X> Y>
  ByFamily(const ByFamily<Y>& other)  // NOLINT(google-explicit-constructor)
      : ranges(other.ranges), samples(other.samples) {}
};

// Calls use(X) of each family. Both: a ByFamily<X>, or a const one.
template <class Both, class Use>
void visit_families(Both& both, const Use& use) {
  use(both.ranges);
  if (both.samples) use(*both.samples);
}

template <class X>
struct ArtifactTraits<ByFamily<X>> {
  static constexpr std::string_view kName = ArtifactTraits<X>::kName;
  static constexpr std::uint32_t kVersion = ArtifactTraits<X>::kVersion;
};
template <HasRows X>
struct ArtifactTraits<ByFamily<StoredTable<X>>> : ArtifactTraits<ByFamily<X>> {
  using Artifact = ByFamily<X>;
};

namespace by_family {

template <class X>
const std::vector<Look>& looks_of(const X& x) {
  if constexpr (requires { x.looks; }) {
    return x.looks;
  } else if constexpr (requires { x.out_of_fold; }) {
    return x.out_of_fold.looks;
  } else if constexpr (requires { x.places; }) {
    return x.places.front().factors.looks;
  } else {
    return x.head().looks;
  }
}

// 0 where an X has no rows of sites.
template <class X>
std::uint64_t row_count(const X& x) {
  if constexpr (HasRows<X>) {
    return RowsOf<X>::count(x);
  } else if constexpr (requires { x.row_count(); }) {
    return x.row_count();
  } else {
    return 0;
  }
}

// Error: invalid-artifact.
Result<void> validate_looks(const std::vector<Look>& ranges, const std::vector<Look>& samples);
Error of_other_sites();

// Adds the rows and promises of the looks that take a sample.
void append_samples(Table samples, Table& table);

}  // namespace by_family

template <class X>
Result<void> validate(const ByFamily<X>& both) {
  SIGHTLINE_TRY(validate(both.ranges));
  if (!both.samples) return {};
  SIGHTLINE_TRY(validate(*both.samples));
  SIGHTLINE_TRY(by_family::validate_looks(by_family::looks_of(both.ranges),
                                          by_family::looks_of(*both.samples)));
  const bool is_of_same_sites =
      by_family::row_count(both.ranges) == by_family::row_count(*both.samples);
  return is_of_same_sites ? Result<void>() : by_family::of_other_sites();
}

template <class X>
Table dump(const ByFamily<X>& both) {
  Table table = dump(both.ranges);
  if (both.samples) by_family::append_samples(dump(*both.samples), table);
  return table;
}

// Whether both are of the same families and looks.
template <class X>
bool has_looks_of(const ByFamily<X>& a, const ByFamily<X>& b) {
  using by_family::looks_of;
  return looks_of(a.ranges) == looks_of(b.ranges) &&
         a.samples.has_value() == b.samples.has_value() &&
         (!a.samples || looks_of(*a.samples) == looks_of(*b.samples));
}

// What make(X...) returns for each family that all have: a Result, the first error of which is
// returned.
template <class Make, class... X>
auto each_family(const Make& make, const ByFamily<X>&... all)
    -> Result<ByFamily<std::remove_cvref_t<decltype(*make(all.ranges...))>>> {
  ByFamily<std::remove_cvref_t<decltype(*make(all.ranges...))>> made;
  SIGHTLINE_ASSIGN(made.ranges, make(all.ranges...));
  if ((all.samples.has_value() && ...)) {
    SIGHTLINE_ASSIGN(made.samples, make(*all.samples...));
  }
  return made;
}

// A list of each family; of the looks that take a sample where all have them.
template <class X>
ByFamily<std::vector<X>> join_families(std::vector<ByFamily<X>> all) {
  ByFamily<std::vector<X>> joined;
  joined.samples.emplace();
  for (ByFamily<X>& both : all) {
    joined.ranges.push_back(std::move(both.ranges));
    if (!both.samples) joined.samples.reset();
    if (joined.samples) joined.samples->push_back(std::move(*both.samples));
  }
  return joined;
}

// Error: cannot-read.
template <HasRows X>
Result<ByFamily<X>> whole_of(const ByFamily<StoredTable<X>>& both) {
  return each_family([](const StoredTable<X>& table) { return table.whole(); }, both);
}

// Without rows, as part of `both`.
template <HasRows X>
ByFamily<const X*> heads_of(const ByFamily<StoredTable<X>>& both) {
  ByFamily<const X*> heads(&both.ranges.head());
  if (both.samples) heads.samples = &both.samples->head();
  return heads;
}

template <HasRows X>
Result<Table> dump(const ByFamily<StoredTable<X>>& both) {
  SIGHTLINE_ASSIGN(const ByFamily<X> whole, whole_of(both));
  return dump(whole);
}

// That of ranges, a byte that is 1 where there are samples, and that of these.
template <class X>
void encode(const ByFamily<X>& both, ByteWriter& writer) {
  encode(both.ranges, writer);
  writer.put<std::uint8_t>(both.samples ? 1 : 0);
  if (both.samples) encode(*both.samples, writer);
}

template <class X>
void decode(ByteReader& reader, ByFamily<X>& both) {
  decode(reader, both.ranges);
  const auto count = reader.get<std::uint8_t>();
  if (count > 1) reader.fail();
  both.samples.reset();
  if (reader.ok() && count == 1) decode(reader, both.samples.emplace());
}

template <InPieces X>
std::uint64_t payload_size(const ByFamily<X>& both) {
  return payload_size(both.ranges) + 1 + (both.samples ? payload_size(*both.samples) : 0);
}

template <InPieces X>
Result<void> visit_payload(const ByFamily<X>& both, const ByteSink& sink) {
  SIGHTLINE_TRY(visit_payload(both.ranges, sink));
  const std::byte count{both.samples ? std::uint8_t{1} : std::uint8_t{0}};
  SIGHTLINE_TRY(sink(std::span(&count, 1)));
  return both.samples ? visit_payload(*both.samples, sink) : Result<void>();
}

template <HasRows X>
Result<void> open_payload(const StoredBytes& payload, ByFamily<StoredTable<X>>& both) {
  ByFamily<StoredTable<X>> opened;
  SIGHTLINE_ASSIGN(opened.ranges, StoredTable<X>::open_front(payload));
  const std::uint64_t size = payload_size(opened.ranges);
  if (size == payload.size()) return undecodable<StoredTable<X>>();
  SIGHTLINE_ASSIGN(const std::vector<std::byte> count, payload.read(size, 1));
  const bool has_samples = count.front() == std::byte{1};
  if (has_samples) {
    SIGHTLINE_ASSIGN(opened.samples,
                     StoredTable<X>::open(payload.part(size + 1, payload.size() - size - 1)));
  } else if (count.front() != std::byte{0} || size + 1 != payload.size()) {
    return undecodable<StoredTable<X>>();
  }
  SIGHTLINE_TRY(validate(opened));
  both = std::move(opened);
  return {};
}

template <HasRows X>
Result<void> open_payload(const StoredBytes& payload, ByFamily<X>& both) {
  ByFamily<StoredTable<X>> opened;
  SIGHTLINE_TRY(open_payload(payload, opened));
  SIGHTLINE_ASSIGN(both, whole_of(opened));
  return {};
}

}  // namespace sightline
