#include "formats/model/place_kind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

namespace sightline {
namespace {

// Walls of a lane are so near that two thirds of all that a site sees lies within this.
constexpr double kLane_m = 10.0;
constexpr double kLaneShare = 2.0 / 3.0;
// Half of what a site sees lies within these; it grows with the distance of the facades.
constexpr double kHalfShare = 0.5;
constexpr double kCanyon_m = 15.0;
constexpr double kCrossing_m = 20.0;
constexpr double kAvenue_m = 30.0;
// A street closes the view but for its two ends; where less than this is closed, streets leave it.
constexpr double kClosedShare = 0.8;
// Of crlb_max: in streets of houses it is 4 to 6 mm, along tunnels, motorways and bridges 10 to 20.
constexpr double kWeak_m = 0.008;
// One direction is held worse than the others by more than this.
constexpr double kOneSided = 2.0;
constexpr double kForestShare = 0.3;  // of NDs that are edges; in streets it is a fifth
// A stretch of road is of one kind.
constexpr double kSmooth_m = 10.0;

// The columns of factors that kinds are made of; none where a table has them not.
class KindFactors {
 public:
  explicit KindFactors(const FactorTable& factors)
      : factors_(factors),
        occupancy_(column_of("occupancy_ratio")),
        strong_(column_of("crlb_min")),
        weak_(column_of("crlb_max")),
        edges_(column_of("d1_ratio")) {}

  [[nodiscard]] bool are_known() const { return occupancy_.has_value(); }

  // The shortest range within which a share of the depth image is hit; infinity where none is.
  [[nodiscard]] double range_of_share(std::size_t site, double share) const {
    for (std::size_t range = 0; range < factors_.looks.size(); ++range) {
      if (factors_.at(site, range, *occupancy_) >= share) return factors_.looks[range].range_m;
    }
    return std::numeric_limits<double>::infinity();
  }
  // At the longest range; 0 where it is not known.
  [[nodiscard]] double closed_share(std::size_t site) const { return last(site, occupancy_); }
  [[nodiscard]] double edge_share(std::size_t site) const { return last(site, edges_); }
  [[nodiscard]] bool is_weak(std::size_t site) const {
    return strong_ && last(site, weak_) > kWeak_m;
  }
  [[nodiscard]] bool is_one_sided(std::size_t site) const {
    return last(site, weak_) > kOneSided * last(site, strong_);
  }

 private:
  [[nodiscard]] std::optional<std::size_t> column_of(std::string_view name) const {
    const auto found = std::ranges::find(factors_.factors, name);
    if (found == factors_.factors.end()) return std::nullopt;
    return static_cast<std::size_t>(found - factors_.factors.begin());
  }
  [[nodiscard]] double last(std::size_t site, const std::optional<std::size_t>& column) const {
    return column ? factors_.at(site, factors_.looks.size() - 1, *column) : 0.0;
  }

  const FactorTable& factors_;
  std::optional<std::size_t> occupancy_, strong_, weak_, edges_;
};

// By the distance of walls alone.
PlaceKind kind_by_walls(const KindFactors& factors, std::size_t site) {
  if (factors.range_of_share(site, kLaneShare) <= kLane_m) return PlaceKind::kLane;
  const double half_m = factors.range_of_share(site, kHalfShare);
  const bool is_closed = factors.closed_share(site) >= kClosedShare;
  if (half_m <= kCrossing_m && !is_closed) return PlaceKind::kCrossing;
  if (half_m <= kCanyon_m) return PlaceKind::kCanyon;
  return half_m <= kAvenue_m ? PlaceKind::kAvenue : PlaceKind::kOpen;
}

PlaceKind kind_of(const KindFactors& factors, std::size_t site) {
  const PlaceKind by_walls = kind_by_walls(factors, site);
  if (factors.edge_share(site) >= kForestShare) return PlaceKind::kForest;
  if (!factors.is_weak(site)) return by_walls;
  const bool is_one_sided = factors.is_one_sided(site);
  if (by_walls == PlaceKind::kOpen || by_walls == PlaceKind::kCrossing) {
    return is_one_sided ? PlaceKind::kOpenRoad : PlaceKind::kField;
  }
  if (!is_one_sided) return PlaceKind::kHall;
  return by_walls == PlaceKind::kLane ? PlaceKind::kTunnel : PlaceKind::kCorridor;
}

}  // namespace

std::vector<PlaceKind> place_kinds(const FactorTable& table) {
  std::vector<PlaceKind> kinds(table.site_count, PlaceKind::kUnknown);
  const KindFactors factors(table);
  if (!factors.are_known()) return kinds;
  for (std::size_t site = 0; site < kinds.size(); ++site) kinds[site] = kind_of(factors, site);
  return kinds;
}

std::vector<PlaceKind> smoothed(const Sites& sites, const std::vector<PlaceKind>& kinds) {
  std::vector<PlaceKind> smooth;
  std::size_t first = 0;
  for (std::size_t site = 0; site < kinds.size(); ++site) {
    const auto is_near = [&](std::size_t other) {
      return sites.sites[other].run == sites.sites[site].run &&
             std::abs(sites.sites[other].s_m - sites.sites[site].s_m) <= kSmooth_m;
    };
    while (!is_near(first)) ++first;
    std::array<std::size_t, kPlaceKindCount> counts{};
    for (std::size_t other = first; other < kinds.size() && is_near(other); ++other) {
      ++counts[static_cast<std::size_t>(kinds[other])];
    }
    const std::size_t most = std::ranges::max(counts);
    const bool keeps_own = counts[static_cast<std::size_t>(kinds[site])] == most;
    smooth.push_back(
        keeps_own ? kinds[site]
                  : static_cast<PlaceKind>(std::ranges::find(counts, most) - counts.begin()));
  }
  return smooth;
}

Result<std::vector<PlaceKind>> place_kinds(const Sites& sites,
                                           const StoredTable<FactorTable>& factors) {
  std::vector<PlaceKind> kinds;
  const std::size_t site_count = factors.row_count();
  for (std::size_t first = 0; first < site_count; first += kRowsAtOnce) {
    SIGHTLINE_ASSIGN(const FactorTable some,
                     factors.rows(first, std::min(kRowsAtOnce, site_count - first)));
    const std::vector<PlaceKind> here = place_kinds(some);
    kinds.insert(kinds.end(), here.begin(), here.end());
  }
  kinds.resize(sites.sites.size(), PlaceKind::kUnknown);
  return smoothed(sites, kinds);
}

PlaceKind place_kind_of(float number) {
  const bool is_known = number >= 0.0F && number < static_cast<float>(kPlaceKindCount);
  return is_known ? static_cast<PlaceKind>(number) : PlaceKind::kUnknown;
}

PlaceKind kind_at(const std::vector<SiteColumn>& columns, std::size_t site) {
  const auto column = std::ranges::find(columns, kPlaceKindColumn, &SiteColumn::name);
  if (column == columns.end()) return PlaceKind::kUnknown;
  return place_kind_of(column->values[site]);
}

}  // namespace sightline
