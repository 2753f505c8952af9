#include "formats/drive/look.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "formats/text/table.h"

namespace sightline {
namespace {

constexpr double kFarthest_m = 1000.0;
constexpr std::string_view kEven = "evenly spaced beyond ";
constexpr std::string_view kByNormals = " by normals";

Error error_of(const std::string& message) {
  return Error{ErrorCode::kBadArgument,
               message +
                   ", expected a look like '50 m' (every return) or '50 m, 2000 returns, evenly "
                   "spaced beyond 30 m, 80 points by normals, settle'",
               "", "a look"};
}

std::string_view trimmed(std::string_view text) {
  const auto first = std::min(text.find_first_not_of(' '), text.size());
  text.remove_prefix(first);
  const std::size_t last = text.find_last_not_of(' ');
  return text.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

// "30 m" with unit " m": the number before it. Nothing where the text is not of this form.
template <class T>
std::optional<T> number_of(std::string_view text, std::string_view unit) {
  if (!text.ends_with(unit)) return std::nullopt;
  text.remove_suffix(unit.size());
  T number{};
  const std::from_chars_result end =
      std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return number;
}

bool take_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

// One part after the range. False where it is none, or stands again or too late.
bool read_part(std::string_view part, int& last, Look& look) {
  const auto take = [&](int place, auto number, auto& value) {
    if (!number || place <= last) return false;
    value = *number;
    last = place;
    return true;
  };
  if (part == "settle") return take(4, std::optional(LookMode::kSettle), look.mode);
  std::string_view even = part;
  // Until 0.2.0 also in the words of earlier versions.
  if (take_prefix(even, kEven) || (take_prefix(even, "even ") && take_prefix(even, "beyond "))) {
    return take(2, number_of<double>(even, " m"), look.even_beyond_m);
  }
  if (part.ends_with(kByNormals)) {
    part.remove_suffix(kByNormals.size());
    look.is_by_normals = true;
    return take(3, number_of<std::uint32_t>(part, " points"), look.point_count);
  }
  return take(1, number_of<std::uint32_t>(part, " returns"), look.return_count) ||
         take(3, number_of<std::uint32_t>(part, " points"), look.point_count);
}

bool is_length(double value_m) { return value_m > 0.0 && value_m < kFarthest_m; }

constexpr std::string_view kNames[kLookSigns] = {"weak sigma",   "strong sigma", "scored share",
                                                 "score",        "nearest",      "moved along",
                                                 "moved across", "turned"};

}  // namespace

std::string to_text(const Look& look) {
  std::string text = format_double(look.range_m) + " m";
  if (look.return_count > 0) text += concat(", ", look.return_count, " returns");
  if (look.even_beyond_m != 0.0) {
    text += concat(", ", kEven, format_double(look.even_beyond_m), " m");
  }
  if (look.point_count > 0) text += concat(", ", look.point_count, " points");
  if (look.is_by_normals) text += kByNormals;
  if (look.mode == LookMode::kSettle) text += ", settle";
  return text;
}

double expected_cost(const Look& look) {
  constexpr double kMatch = 240.0;  // whatever is matched
  constexpr double kReturn = 1.0 / 18.0;
  const std::uint32_t points = look.point_count > 0 ? look.point_count : look.return_count;
  return kMatch + kReturn * look.return_count + points;
}

Result<Look> parse_look(std::string_view text) {
  const auto part_at = [&](std::size_t begin) {
    return trimmed(text.substr(begin, text.find(',', begin) - begin));
  };
  const std::string quoted = concat("'", text, "'");
  Look look;
  const std::optional<double> range_m = number_of<double>(part_at(0), " m");
  if (!range_m) return error_of(quoted + " does not begin with a range");
  look.range_m = *range_m;
  int last = 0;
  for (std::size_t comma = text.find(','); comma != std::string_view::npos;
       comma = text.find(',', comma + 1)) {
    const std::string_view part = part_at(comma + 1);
    if (!read_part(part, last, look)) {
      return error_of(concat("'", part, "' in ", quoted, " is unknown or not in this order"));
    }
  }
  const Result<void> valid = validate(look);
  if (!valid) return valid.error();
  return look;
}

std::string to_text(const std::vector<Look>& looks) {
  std::string text;
  for (const Look& look : looks) text += (text.empty() ? "" : "; ") + to_text(look);
  return text;
}

Result<std::vector<Look>> parse_looks(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('[') && text.ends_with(']')) text = text.substr(1, text.size() - 2);
  std::vector<std::string> texts;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(",;"), text.size());
    const std::string_view part = trimmed(text.substr(0, end));
    if (texts.empty() || number_of<double>(part, " m")) {
      texts.emplace_back(part);
    } else {
      texts.back() += ", " + std::string(part);
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (texts.empty()) return error_of("found no look");
  std::vector<Look> looks;
  for (const std::string& each : texts) {
    SIGHTLINE_ASSIGN(const Look look, parse_look(each));
    if (std::ranges::find(looks, look) != looks.end())
      return error_of(concat("'", each, "' is listed twice"));
    looks.push_back(look);
  }
  return looks;
}

Result<void> validate(const Look& look) {
  // Vehicles check a look at each scan: a good one allocates nothing.
  const auto quoted = [&] { return concat("'", to_text(look), "'"); };
  if (!is_length(look.range_m)) {
    return error_of(quoted() + ": the range is not above 0 and below 1000 m");
  }
  if (look.even_beyond_m != 0.0 && !is_length(look.even_beyond_m)) {
    return error_of(quoted() + ": 'evenly spaced beyond' is not above 0 and below 1000 m");
  }
  const bool is_sample = look.even_beyond_m != 0.0 || look.point_count > 0 || look.is_by_normals;
  if (is_sample && look.return_count == 0) {
    return error_of(quoted() + " takes a sample: add how many returns, for example '2000 returns'");
  }
  if (look.is_by_normals && look.point_count == 0) {
    return error_of(quoted() +
                    " takes points by normals: add how many, for example '80 points by normals'");
  }
  return {};
}

std::vector<Look> every_return_at(const std::vector<double>& ranges_m) {
  std::vector<Look> looks;
  for (const double range_m : ranges_m) looks.push_back(every_return(range_m));
  return looks;
}

std::vector<double> ranges_of(const std::vector<Look>& looks) {
  std::vector<double> ranges_m;
  for (const Look& look : looks) ranges_m.push_back(look.range_m);
  return ranges_m;
}

Result<void> validate(const std::vector<Look>& looks) {
  const auto invalid = [](const std::string& message, std::size_t number) {
    return Error{ErrorCode::kInvalidArtifact, message, "", concat("look ", number)};
  };
  if (looks.empty()) return invalid("found no look, expected one or more", 0);
  double range_m = 0.0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const Result<void> valid = validate(looks[i]);
    if (!valid) return invalid(valid.error().message, i);
    const auto here = looks.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(looks.begin(), here, looks[i]) != here) {
      return invalid(concat("found '", to_text(looks[i]), "' twice"), i);
    }
    if (!takes_every_return(looks[i])) continue;
    if (looks[i].range_m < range_m) {
      return invalid(concat("found range ", format_double(looks[i].range_m), " m after ",
                            format_double(range_m), " m, expected ascending ones"),
                     i);
    }
    range_m = looks[i].range_m;
  }
  return {};
}

std::span<const std::string_view> look_sign_names() { return kNames; }

double doubt_of(const LookTest& test, const LookSigns& signs) {
  double doubt = test.constant;
  for (std::size_t i = 0; i < kLookSigns; ++i) doubt += test.weights[i] * signs[i];
  return doubt;
}

Result<void> validate(const LookPlan& plan) {
  SIGHTLINE_TRY(validate(plan.first));
  SIGHTLINE_TRY(validate(plan.second));
  const auto is_finite = [](double value) { return std::isfinite(value); };
  const bool is_usable = std::ranges::all_of(plan.test.weights, is_finite) &&
                         is_finite(plan.test.constant) && !std::isnan(plan.doubt_above) &&
                         is_finite(plan.limit_m) && plan.limit_m > 0.0;
  if (is_usable) return {};
  return Error{ErrorCode::kBadArgument,
               "the plan's test is invalid, expected finite weights, a threshold that is a number, "
               "and a limit above 0 m",
               "", "a plan of looks"};
}

LookPlan plan_at(const LookPlan& plan, const Look& look) {
  LookPlan there = plan;
  const bool is_cheaper = !takes_every_return(look) && look.point_count > 0 &&
                          look.return_count <= plan.first.return_count &&
                          look.point_count < plan.first.point_count;
  if (is_cheaper) there.first = look;
  there.first.mode = LookMode::kSettle;
  return there;
}

std::string to_text(const LookPlan& plan) {
  return concat("from ", format_double(plan.limit_m), " m: first ", to_text(plan.first),
                "; where the test rejects its result, ", to_text(plan.second));
}

}  // namespace sightline
