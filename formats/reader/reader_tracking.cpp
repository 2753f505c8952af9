#include <algorithm>
#include <limits>

#include "formats/reader/reader.h"
#include "formats/reader/site_looks.h"

// The answers of a MapReader for vehicles that track.

namespace sightline {

Result<TrackingLookColumns> MapReader::read_tracking_looks() const {
  TrackingLookColumns columns;
  for (std::size_t limit = 0; limit < limits_m_.size(); ++limit) {
    const std::string name = tracking_look_column(0, limit);
    if (std::ranges::find(columns_, name) == columns_.end()) return TrackingLookColumns();
    SIGHTLINE_ASSIGN(const MapErrors::Column numbers, stepped_column(name));
    SIGHTLINE_ASSIGN(const MapErrors::Column probabilities,
                     stepped_column(tracking_look_column(1, limit)));
    columns.push_back({numbers, probabilities});
  }
  return columns;
}

Result<LookAnswer> MapReader::tracking_look(const LookAnswer& look, double limit_m,
                                            double visible_m) const {
  constexpr std::uint32_t kNone = kAnswerFar | kAnswerTighterLimit | kAnswerUnknownLocalizer;
  const std::optional<std::size_t> limit = limit_for(limit_m);
  if (!limit || (look.flags & kNone) != 0) return look;
  std::call_once(tracking_->is_read, [&] { tracking_->columns = read_tracking_looks(); });
  const Result<TrackingLookColumns>& columns = tracking_->columns;
  if (!columns) return columns.error();
  if (columns->empty()) return look;
  const auto& [numbers, probabilities] = (*columns)[*limit];
  const double number = numbers.at(look.site);
  const double index = number >= 0.0 ? number : -1.0 - number;
  if (!(index >= 0.0 && index < static_cast<double>(looks_.size()))) {
    return Error{ErrorCode::kBadLayer, "a site has a look that the map does not have", "",
                 "site " + std::to_string(look.site)};
  }
  const MapLook& chosen = looks_[static_cast<std::size_t>(index)];
  if (!(chosen.range_m <= visible_m)) return look;
  LookAnswer answer = look;
  answer.look = chosen;
  answer.probability = probabilities.at(look.site);
  answer.mean_error_m = std::numeric_limits<double>::quiet_NaN();
  answer.flags &= ~static_cast<std::uint32_t>(kAnswerUnmet);
  if (number < 0.0) answer.flags |= kAnswerUnmet;
  return answer;
}

}  // namespace sightline
