#include "passes/pass/work_in_parts.h"

#include <algorithm>
#include <atomic>

#include "formats/base/check.h"
#include "formats/base/parallel.h"

namespace sightline {
namespace {

// How many threads the i-th of `count` parts may use, of which `at_once` are made side by side.
int threads_of_part(const PassContext& ctx, int at_once, std::size_t i, std::size_t count) {
  return threads_each(ctx.threads, std::min(static_cast<std::size_t>(at_once), count - i));
}

// The first call that failed, by its number.
class FirstFailure {
 public:
  void note(std::size_t call) {
    std::size_t known = call_.load();
    while (call < known && !call_.compare_exchange_weak(known, call)) {
    }
  }
  [[nodiscard]] bool is_before(std::size_t call) const { return call_.load() < call; }
  [[nodiscard]] std::optional<std::size_t> call() const {
    const std::size_t call = call_.load();
    return call == kNone ? std::nullopt : std::optional(call);
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::atomic<std::size_t> call_ = kNone;
};

// Whether that worked.
using Take = std::function<bool(std::size_t)>;

// Calls take(i) for each i in [0, count), side by side; they begin in this order, and none begins
// after a failure. All before the first that fails are made, so that it is the same one for any
// number of threads. Returns that one.
std::optional<std::size_t> take_in_order(std::size_t count, int at_once, const Take& take) {
  std::atomic<std::size_t> next = 0;
  FirstFailure failure;
  parallel_for(count, at_once, [&](std::size_t) {
    const std::size_t i = next++;
    if (!failure.is_before(i) && !take(i)) failure.note(i);
  });
  return failure.call();
}

// Calls take(i) for each i in [0, count), in as many stretches as threads; a thread that is done
// with its own helps with the next. None begins after a failure. Returns the first of those that
// failed.
std::optional<std::size_t> take_apart(std::size_t count, int at_once, const Take& take) {
  const auto stretches = static_cast<std::size_t>(at_once);
  std::vector<std::atomic<std::size_t>> next(stretches);
  for (std::size_t s = 0; s < stretches; ++s) next[s] = count * s / stretches;
  FirstFailure failure;
  parallel_for(stretches, at_once, [&](std::size_t own) {
    for (std::size_t k = 0; k < stretches; ++k) {
      const std::size_t s = (own + k) % stretches;
      const std::size_t end = count * (s + 1) / stretches;
      for (std::size_t i = next[s]++; i < end && !failure.call(); i = next[s]++) {
        if (!take(i)) failure.note(i);
      }
    }
  });
  return failure.call();
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
        return false;
      }
      if (ctx.part_sink) ctx.part_sink(names[part], *made);
      const bool is_taken = work.take(part, *made);
      SIGHTLINE_CHECK(is_taken);
    }
    ctx.progress(++done, work.count);
    return true;
  };
  const std::size_t begin = work.count * ctx.share.number / ctx.share.of;
  const std::size_t end = work.count * (ctx.share.number + 1) / ctx.share.of;
  const auto take_each = work.order == PartOrder::kApart ? take_apart : take_in_order;
  const auto failed = take_each(end - begin, at_once, [&](std::size_t i) {
    return take_part(begin + i, threads_of_part(ctx, at_once, i, end - begin));
  });
  if (failed) return *failures[begin + *failed];
  // Backwards: another process may be at work on these parts, from their beginning.
  const std::size_t left = work.count - (end - begin);
  const auto part_left = [&](std::size_t i) { return (begin + work.count - 1 - i) % work.count; };
  const auto failed_left = take_each(left, at_once, [&](std::size_t i) {
    return take_part(part_left(i), threads_of_part(ctx, at_once, i, left));
  });
  if (failed_left) return *failures[part_left(*failed_left)];
  return {};
}

}  // namespace sightline
