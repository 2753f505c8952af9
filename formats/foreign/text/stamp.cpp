#include "formats/foreign/text/stamp.h"

#include <array>
#include <chrono>
#include <limits>

#include "formats/base/units.h"
#include "formats/foreign/text/text_lines.h"

// Times are 19 significant digits long; a double carries 15. So they are never numbers until they
// are whole nanoseconds: the decimal point is moved in the text.

namespace sightline {
namespace {

// A decimal number taken apart: digits without the point, and how many stand before it.
struct Decimal {
  std::string digits;
  long point = 0;
  bool is_negative = false;
  bool is_whole = false;  // neither point nor exponent
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::optional<Decimal> parse_decimal(std::string_view word) {
  constexpr long kLargestExponent = 30;
  Decimal decimal;
  if (word.starts_with('-') || word.starts_with('+')) {
    decimal.is_negative = word.front() == '-';
    word.remove_prefix(1);
  }
  const std::size_t exponent_at = word.find_first_of("eE");
  const std::string_view mantissa = word.substr(0, exponent_at);
  const std::size_t point_at = mantissa.find('.');
  decimal.is_whole = exponent_at == std::string_view::npos && point_at == std::string_view::npos;
  for (std::size_t i = 0; i < mantissa.size(); ++i) {
    if (i == point_at) continue;
    if (!is_digit(mantissa[i])) return std::nullopt;
    decimal.digits += mantissa[i];
  }
  if (decimal.digits.empty()) return std::nullopt;
  decimal.point = static_cast<long>(std::min(point_at, mantissa.size()));
  if (exponent_at != std::string_view::npos) {
    const std::optional<long> exponent = to_number<long>(word.substr(exponent_at + 1));
    if (!exponent || std::labs(*exponent) > kLargestExponent) return std::nullopt;
    decimal.point += *exponent;
  }
  return decimal;
}

// Digits before the point once it has moved right by `shift`, rounded half up.
std::optional<std::int64_t> shifted(const Decimal& decimal, long shift) {
  const long end = decimal.point + shift;
  std::uint64_t value = 0;
  for (long i = 0; i < end; ++i) {
    const bool has_digit = i < static_cast<long>(decimal.digits.size());
    const auto digit = static_cast<std::uint64_t>(
        has_digit ? decimal.digits[static_cast<std::size_t>(i)] - '0' : 0);
    // Half of what fits (the year 2116), so that no difference of two times overflows.
    constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() / 2);
    if (value > (kMost - digit) / 10) return std::nullopt;
    value = 10 * value + digit;
  }
  const bool rounds_up = end >= 0 && end < static_cast<long>(decimal.digits.size()) &&
                         decimal.digits[static_cast<std::size_t>(end)] >= '5';
  const auto whole = static_cast<std::int64_t>(value + (rounds_up ? 1 : 0));
  return decimal.is_negative ? -whole : whole;
}

}  // namespace

std::optional<std::int64_t> parse_stamp_ns(std::string_view word) {
  constexpr long kMillisecondDigits = 12;         // as seconds, after the year 5000
  constexpr std::size_t kMicrosecondDigits = 15;  // as seconds, 30 million years
  constexpr std::size_t kNanosecondDigits = 18;
  const std::optional<Decimal> decimal = parse_decimal(word);
  if (!decimal) return std::nullopt;
  const std::size_t zeros = decimal->digits.find_first_not_of('0');
  const std::size_t length = zeros == std::string::npos ? 0 : decimal->digits.size() - zeros;
  if (decimal->is_whole && length >= kNanosecondDigits) return shifted(*decimal, 0);
  if (decimal->is_whole && length >= kMicrosecondDigits) return shifted(*decimal, 3);
  const bool is_zero = zeros == std::string::npos;
  if (!is_zero && decimal->point - static_cast<long>(zeros) >= kMillisecondDigits) {
    return shifted(*decimal, 6);
  }
  return shifted(*decimal, 9);
}

std::string format_stamp(std::int64_t stamp_ns) {
  const std::uint64_t size = stamp_ns < 0 ? 0 - static_cast<std::uint64_t>(stamp_ns)
                                          : static_cast<std::uint64_t>(stamp_ns);
  const std::string decimals = std::to_string(size % kSecond_ns);
  std::string text = std::to_string(size / kSecond_ns);
  text.append(1, '.').append(9 - decimals.size(), '0').append(decimals);
  if (stamp_ns < 0) text.insert(text.begin(), '-');
  return text;
}

std::optional<std::int64_t> parse_date_time_ns(std::string_view date, std::string_view time) {
  namespace chrono = std::chrono;
  const auto number = [](std::string_view text, std::size_t at, std::size_t length) {
    return to_number<int>(text.substr(at, length));
  };
  if (date.size() != 10 || date[4] != '-' || date[7] != '-') return std::nullopt;
  if (time.size() < 8 || time[2] != ':' || time[5] != ':') return std::nullopt;
  const std::optional<int> year = number(date, 0, 4);
  const std::optional<int> month = number(date, 5, 2);
  const std::optional<int> day = number(date, 8, 2);
  const std::optional<int> hours = number(time, 0, 2);
  const std::optional<int> minutes = number(time, 3, 2);
  const std::optional<std::int64_t> seconds_ns = parse_stamp_ns(time.substr(6));
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  if (!year || !month || !day || !hours || !minutes || !seconds_ns) return std::nullopt;
  if (*year < 1970 || *year > 2100 || *month < 1 || *day < 1) return std::nullopt;
  if (*hours < 0 || *hours > 23 || *minutes < 0 || *minutes > 59) return std::nullopt;
  if (*seconds_ns < 0 || *seconds_ns > kMinute_ns) return std::nullopt;
  const chrono::year_month_day when{chrono::year(*year),
                                    chrono::month(static_cast<unsigned>(*month)),
                                    chrono::day(static_cast<unsigned>(*day))};
  if (!when.ok()) return std::nullopt;
  const auto days = chrono::sys_days(when).time_since_epoch().count();
  return (std::int64_t{days} * 1440 + *hours * 60 + *minutes) * kMinute_ns + *seconds_ns;
}

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
