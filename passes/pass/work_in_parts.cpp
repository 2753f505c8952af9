#include "passes/pass/work_in_parts.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>

#include "formats/base/check.h"
#include "formats/base/parallel.h"

namespace sightline {

namespace {

// How many threads the i-th of `count` parts may use, of which `at_once` are made side by side.
int threads_of_part(const PassContext& ctx, int at_once, std::size_t i, std::size_t count) {
  return threads_each(ctx.threads, std::min(static_cast<std::size_t>(at_once), count - i));
}

// Calls take(i) for each i in [0, count), side by side; they begin in this order.
void take_in_order(std::size_t count, int at_once, const std::function<void(std::size_t)>& take) {
  std::atomic<std::size_t> next = 0;
  parallel_for(count, at_once, [&](std::size_t) { take(next++); });
}

// The same in as many stretches as threads; who is done with one helps with the next.
void take_apart(std::size_t count, int at_once, const std::function<void(std::size_t)>& take) {
  const auto stretches = static_cast<std::size_t>(at_once);
  std::vector<std::atomic<std::size_t>> next(stretches);
  for (std::size_t s = 0; s < stretches; ++s) next[s] = count * s / stretches;
  parallel_for(stretches, at_once, [&](std::size_t own) {
    for (std::size_t k = 0; k < stretches; ++k) {
      const std::size_t s = (own + k) % stretches;
      const std::size_t end = count * (s + 1) / stretches;
      for (std::size_t i = next[s]++; i < end; i = next[s]++) take(i);
    }
  });
}

}  // namespace

Result<void> work_in_parts(const PassContext& ctx, const PartedWork& work, int at_once) {
  at_once = at_once > 0 ? at_once : threads_each(ctx.threads, 1);
  std::vector<PartName> names(work.count);
  parallel_for(work.count, at_once, [&](std::size_t part) {
    names[part].number = part;
    if (work.content) names[part].content = work.content(part);
  });
  if (ctx.parts_sink) ctx.parts_sink(names);
  std::vector<std::optional<Error>> failures(work.count);
  std::atomic<std::size_t> done = 0;
  const auto take_part = [&](std::size_t part, int threads) {
    const auto saved = ctx.saved_part ? ctx.saved_part(names[part]) : std::nullopt;
    if (!saved || !work.take(part, *saved)) {
      const Result<std::vector<std::byte>> made = work.make(part, threads);
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
  const auto take_each = work.order == PartOrder::kApart ? take_apart : take_in_order;
  take_each(end - begin, at_once, [&](std::size_t i) {
    take_part(begin + i, threads_of_part(ctx, at_once, i, end - begin));
  });
  // Backwards: whoever has those parts is still at work on them from their beginning.
  const std::size_t left = work.count - (end - begin);
  take_each(left, at_once, [&](std::size_t i) {
    take_part((begin + work.count - 1 - i) % work.count, threads_of_part(ctx, at_once, i, left));
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

}  // namespace sightline
