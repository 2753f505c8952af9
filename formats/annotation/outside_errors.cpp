#include "formats/annotation/outside_errors.h"

#include <cmath>
#include <tuple>

namespace sightline {
namespace {

Error invalid_line(const std::string& message, std::uint32_t line) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("line ", line)};
}

auto key_of(const OutsideError& error) {
  return std::tuple(error.scan, error.range_m, error.start);
}

}  // namespace

Result<void> validate(const OutsideErrors& outside) {
  SIGHTLINE_TRY(validate(outside.localizer));
  for (std::size_t i = 0; i < outside.errors.size(); ++i) {
    const OutsideError& error = outside.errors[i];
    if (!std::isfinite(error.range_m) || error.range_m <= 0.0) {
      return invalid_line(concat("found a range of ", format_double(error.range_m),
                                 " m, expected a finite one above 0"),
                          error.line);
    }
    if (!std::isfinite(error.error_m) || error.error_m < 0.0) {
      return invalid_line(concat("found an error of ", format_double(error.error_m),
                                 " m, expected a finite number of at least 0 m"),
                          error.line);
    }
    if (i > 0 && key_of(outside.errors[i - 1]) >= key_of(error)) {
      return invalid_line(concat("found scan ", error.scan, ", ", format_double(error.range_m),
                                 " m, start ", error.start, " twice or out of order"),
                          error.line);
    }
  }
  return {};
}

Table dump(const OutsideErrors& outside) {
  Table table{"outside-errors", {"scan", "range_m", "start", "error_m"}, {}, {}};
  table.facts.emplace_back("file", outside.file);
  table.facts.emplace_back("localizer", to_text(outside.localizer));
  for (const OutsideError& error : outside.errors) {
    table.rows.push_back(
        {std::int64_t{error.scan}, error.range_m, std::int64_t{error.start}, error.error_m});
  }
  return table;
}

}  // namespace sightline
