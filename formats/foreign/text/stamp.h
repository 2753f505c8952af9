#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

// A time in seconds ("1567410201.7452047", "1.5e9") or, where too large for seconds, in
// milliseconds (12 to 14 digits before the point), or as a whole number in microseconds (15 to 17
// digits) or nanoseconds (18 and more). Exact to the ns; half a ns rounds up. nullopt: no time.
std::optional<std::int64_t> parse_stamp_ns(std::string_view word);

// Seconds with nine decimals, which parse_stamp_ns reads back exactly.
std::string format_stamp(std::int64_t stamp_ns);

// "2011-09-26" and "13:02:25.594360375", UTC. nullopt: none.
std::optional<std::int64_t> parse_date_time_ns(std::string_view date, std::string_view time);

// Divides ascending times that were read as seconds but are whole numbers of a finer unit, where
// half of their steps are 20 s or more, so that the middle step is below. Returns the unit:
// "milliseconds", "microseconds" or "nanoseconds"; "" where they stay.
std::string take_finer_unit(std::vector<std::int64_t>& stamps_ns);

// In the order of their times; of several at one time the first stays.
template <class Timed, class Stamp>
void sort_once(std::vector<Timed>& items, const Stamp& stamp) {
  std::ranges::stable_sort(items, {}, stamp);
  const auto is_same_time = [&](const Timed& a, const Timed& b) { return stamp(a) == stamp(b); };
  items.erase(std::unique(items.begin(), items.end(), is_same_time), items.end());
}

}  // namespace sightline
