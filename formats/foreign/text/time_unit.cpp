#include "formats/foreign/text/time_unit.h"

#include <algorithm>
#include <array>

#include "formats/base/units.h"

namespace sightline {

std::string take_finer_unit(std::vector<std::int64_t>& stamps_ns) {
  constexpr std::int64_t kLongestStep_ns = 20 * kSecond_ns;
  static constexpr std::array kUnits = {"milliseconds", "microseconds", "nanoseconds"};
  const bool are_whole = std::ranges::all_of(
      stamps_ns, [](std::int64_t stamp_ns) { return stamp_ns % kSecond_ns == 0; });
  if (!are_whole || stamps_ns.size() < 2) return "";
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) {
    steps_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  }
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::ranges::nth_element(steps_ns, middle);
  std::int64_t parts = 1;
  std::string unit;
  for (std::size_t i = 0; i < kUnits.size() && *middle / parts >= kLongestStep_ns; ++i) {
    parts *= 1000;
    unit = kUnits[i];
  }
  for (std::int64_t& stamp_ns : stamps_ns) stamp_ns /= parts;
  return unit;
}

}  // namespace sightline
