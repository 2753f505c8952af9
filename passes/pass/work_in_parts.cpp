#include "passes/pass/work_in_parts.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/parallel.h"

namespace sightline {

namespace {

// Calls take(part) once for each, side by side; they begin in this order.
void take_in_order(const std::vector<std::size_t>& parts, int threads,
                   const std::function<void(std::size_t part)>& take) {
  std::atomic<std::size_t> next = 0;
  parallel_for(parts.size(), threads, [&](std::size_t) { take(parts[next++]); });
}

void heaviest_first(const PartedWork& work, std::vector<std::size_t>& parts) {
  if (!work.weight) return;
  std::vector<double> weights(work.count);
  for (const std::size_t part : parts) weights[part] = work.weight(part);
  std::ranges::stable_sort(parts, std::greater<>(),
                           [&](std::size_t part) { return weights[part]; });
}

}  // namespace

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
  std::vector<std::size_t> own(end - begin);
  std::iota(own.begin(), own.end(), begin);
  heaviest_first(work, own);
  take_in_order(own, threads, take_part);
  // Backwards: whoever has those parts is still at work on them from their beginning.
  std::vector<std::size_t> others;
  for (std::size_t i = 1; i <= work.count - own.size(); ++i) {
    others.push_back((begin + work.count - i) % work.count);
  }
  take_in_order(others, threads, take_part);
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

}  // namespace sightline
