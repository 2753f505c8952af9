#include "passes/pass/work_in_parts.h"

#include <atomic>
#include <optional>

#include "formats/base/check.h"
#include "formats/base/parallel.h"

namespace sightline {

Result<void> work_in_parts(const PassContext& ctx, const PartedWork& work, int threads) {
  std::vector<PartName> names(work.count);
  parallel_for(work.count, threads, [&](std::size_t part) {
    names[part].number = part;
    if (work.content) names[part].content = work.content(part);
  });
  if (ctx.parts_sink) ctx.parts_sink(names);
  std::vector<std::optional<Error>> failures(work.count);
  std::atomic<std::size_t> done = 0;
  const auto take_part = [&](std::size_t part) {
    const auto saved = ctx.saved_part ? ctx.saved_part(names[part]) : std::nullopt;
    if (!saved || !work.take(part, *saved)) {
      const Result<std::vector<std::byte>> made = work.make(part);
      if (!made) {
        failures[part] = made.error();
        return;
      }
      if (ctx.part_sink) ctx.part_sink(names[part], *made);
      const bool is_taken = work.take(part, *made);
      SIGHTLINE_CHECK(is_taken);
    }
    ctx.progress(++done, work.count);
  };
  const std::size_t begin = work.count * ctx.share.number / ctx.share.of;
  const std::size_t end = work.count * (ctx.share.number + 1) / ctx.share.of;
  parallel_for(end - begin, threads, [&](std::size_t i) { take_part(begin + i); });
  // Backwards: whoever has those parts is still at work on them from their beginning.
  parallel_for(work.count - (end - begin), threads,
               [&](std::size_t i) { take_part((begin + work.count - 1 - i) % work.count); });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

}  // namespace sightline
