#include "passes/model/forest/same_street.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

constexpr double kNear_m = 20.0;
constexpr double kShare = 0.2;
constexpr double kLeastAgreement = 0.9;
constexpr double kLeastRoute_m = 40.0;  // shorter ones agree by chance
constexpr double kFarthestOwn_m = 1e5;

using SitePair = std::pair<std::size_t, std::size_t>;

std::vector<Eigen::Vector3d> route_of(const DrivenPlace& place) {
  std::vector<Eigen::Vector3d> route_m;
  for (const Site& site : place.sites.sites) {
    route_m.push_back(place.sites.frame.origin_world_m + site.p_map_m);
  }
  return route_m;
}

double length_m(const DrivenPlace& place) {
  return static_cast<double>(place.sites.sites.size()) * place.sites.spacing_m;
}

bool is_of_the_world(const Eigen::Vector3d& p_world_m) {
  return p_world_m.head<2>().cwiseAbs().maxCoeff() > kFarthestOwn_m;
}

// Each site of `a` with the nearest one of `b`.
std::vector<SitePair> near_pairs(const std::vector<Eigen::Vector3d>& a,
                                 const std::vector<Eigen::Vector3d>& b) {
  const PointGrid grid(b);
  std::vector<SitePair> pairs;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::optional<NearPoint> near = grid.nearest(a[i], kNear_m);
    if (near) pairs.emplace_back(i, near->index);
  }
  return pairs;
}

// What a map looks like: neither a direction, which turns with its axes, nor an error.
bool is_appearance(const std::string& factor) {
  return !factor.ends_with("_heading") && !factor.ends_with("error") &&
         !factor.starts_with("measured_");
}

// Pearson's; nothing where either is the same everywhere.
std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto count = static_cast<double>(a.size());
  double sum_a = 0.0, sum_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum_a += a[i], sum_b += b[i];
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double of_a = a[i] - sum_a / count;
    const double of_b = b[i] - sum_b / count;
    aa += of_a * of_a, bb += of_b * of_b, ab += of_a * of_b;
  }
  constexpr double kLeast = 1e-12;
  if (aa < kLeast || bb < kLeast) return std::nullopt;
  return ab / std::sqrt(aa * bb);
}

std::vector<double> values_at(const FactorTable& factors, std::size_t factor,
                              const std::vector<SitePair>& pairs, std::size_t SitePair::*side) {
  std::vector<double> values;
  for (const SitePair& pair : pairs) {
    values.push_back(factors.at(pair.*side, factors.looks.size() - 1, factor));
  }
  return values;
}

// The median over factors; 0 where none varies.
double agreement(const DrivenPlace& a, const DrivenPlace& b, const std::vector<SitePair>& pairs) {
  std::vector<double> correlations;
  for (std::size_t factor = 0; factor < a.factors.factors.size(); ++factor) {
    if (!is_appearance(a.factors.factors[factor])) continue;
    const std::optional<double> found =
        correlation(values_at(a.factors, factor, pairs, &SitePair::first),
                    values_at(b.factors, factor, pairs, &SitePair::second));
    if (found) correlations.push_back(*found);
  }
  if (correlations.empty()) return 0.0;
  std::ranges::sort(correlations);
  return correlations[correlations.size() / 2];
}

}  // namespace

bool is_one_street(const DrivenPlace& a, const DrivenPlace& b) {
  if (length_m(b) < length_m(a)) return is_one_street(b, a);
  const std::vector<Eigen::Vector3d> of_a = route_of(a);
  const std::vector<Eigen::Vector3d> of_b = route_of(b);
  if (of_a.empty()) return false;
  const std::vector<SitePair> pairs = near_pairs(of_a, of_b);
  if (static_cast<double>(pairs.size()) <= kShare * static_cast<double>(of_a.size())) return false;
  if (is_of_the_world(of_a.front()) && is_of_the_world(of_b.front())) return true;
  const double compared_m = static_cast<double>(pairs.size()) * a.sites.spacing_m;
  return compared_m >= kLeastRoute_m && a.factors.factors == b.factors.factors &&
         a.factors.looks == b.factors.looks && agreement(a, b, pairs) >= kLeastAgreement;
}

Origins origins_of(const DrivenPlaces& places) {
  std::vector<const RecordingCards*> recordings;
  for (const DrivenPlace& place : places.places) recordings.push_back(&place.recordings);
  Origins origins = origins_by_recording(recordings);
  for (std::size_t i = 0; i < places.places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (origins.places[i] == origins.places[j]) continue;
      if (is_one_street(places.places[i], places.places[j])) join_places(i, j, origins);
    }
  }
  return origins;
}

}  // namespace sightline
