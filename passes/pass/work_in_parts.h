#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/record/codec.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What threads take at the same time. Neighbours often look at the same scans, which are then read
// once for both: they are made side by side. Where neighbours need something that only one of them
// can make, and each has scans of its own, every thread begins in a stretch of its own.
enum class PartOrder { kSideBySide, kApart };

// Work of a pass that falls into parts, each of which depends on the pass, its options and its
// inputs alone.
struct PartedWork {
  std::size_t count = 0;  // of parts
  // What decides a part's bytes besides the pass, its options and the seed, known without making
  // it: a part of equal content has equal bytes, whatever else of the inputs is another. Called
  // side by side. May be empty or give nothing: then any of the inputs may decide.
  std::function<std::optional<Digest>(std::size_t part)> content = {};
  // The bytes of one part; called side by side. It may use so many threads: more than its share
  // where fewer parts are left than are made side by side.
  std::function<Result<std::vector<std::byte>>(std::size_t part, int threads)> make;
  // Puts a part where it belongs, and says whether the bytes are such a part: what lies in a store
  // may be anything. Called side by side, once for each part that is taken.
  std::function<bool(std::size_t part, std::span<const std::byte> bytes)> take;
  PartOrder order = PartOrder::kSideBySide;
};

// Takes every part: as it was saved, else it is made and saved, through bytes either way. Those of
// ctx.share come first, then the others backwards from there: processes of different shares meet.
// They begin in that order, or stretch by stretch (PartOrder); `at_once` of them (0: as many as
// ctx.threads, which they share). After a failure those that have begun are finished and saved, and
// no further one begins. Side by side, the failure of the part that begins first is returned, which
// does not depend on the number of threads; else the one of the lowest part that failed.
Result<void> work_in_parts(const PassContext& ctx, const PartedWork& work, int at_once = 0);

// Work whose parts are records, or what holds records: their bytes are those of record/codec.h.
template <class Part>
struct RecordWork {
  std::size_t count = 0;  // as in PartedWork
  std::function<std::optional<Digest>(std::size_t part)> content = {};
  std::function<Result<Part>(std::size_t part, int threads)> make;
  std::function<bool(std::size_t part, Part found)> take;
  PartOrder order = PartOrder::kSideBySide;
};

template <class Part>
Result<void> work_in_parts(const PassContext& ctx, const RecordWork<Part>& work, int at_once = 0) {
  const auto make = [&](std::size_t part, int threads) -> Result<std::vector<std::byte>> {
    SIGHTLINE_ASSIGN(const Part made, work.make(part, threads));
    return written(made).take();
  };
  const auto take = [&](std::size_t part, std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    Part found;
    FieldReader(reader).get(found);
    return reader.at_end() && work.take(part, std::move(found));
  };
  return work_in_parts(ctx, {work.count, work.content, make, take, work.order}, at_once);
}

// All parts, in their order; `work` has no take().
template <class Part>
Result<std::vector<Part>> make_parts(const PassContext& ctx, RecordWork<Part> work) {
  std::vector<Part> parts(work.count);
  work.take = [&](std::size_t part, Part found) {
    parts[part] = std::move(found);
    return true;
  };
  SIGHTLINE_TRY(work_in_parts(ctx, work));
  return parts;
}

}  // namespace sightline
