#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>

#include "formats/base/units.h"
#include "formats/foreign/text/pose_file.h"
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

}  // namespace sightline
