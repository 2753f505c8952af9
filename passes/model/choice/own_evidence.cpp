#include "passes/model/choice/own_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

// Shares of sites that are equal may differ in their last bit.
constexpr double kRounding = 1e-12;

std::optional<std::size_t> column_of(const FactorTable& factors, std::string_view name) {
  const auto found = std::ranges::find(factors.factors, name);
  if (found == factors.factors.end()) return std::nullopt;
  return static_cast<std::size_t>(found - factors.factors.begin());
}

std::vector<double> values_of(const FactorTable& factors, std::size_t column) {
  std::vector<double> values;
  values.reserve(factors.looks.size() * factors.site_count);
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (std::size_t range = 0; range < factors.looks.size(); ++range) {
      values.push_back(factors.at(site, range, column));
    }
  }
  return values;
}

std::vector<double> cost_of(const FactorTable& factors) {
  for (const char* name : {"match_cost", "virtual_points"}) {
    const std::optional<std::size_t> column = column_of(factors, name);
    if (column) return values_of(factors, *column);
  }
  std::vector<double> cost;
  for (std::size_t site = 0; site < factors.site_count; ++site) {
    for (const Look& look : factors.looks) cost.push_back(look.range_m);
  }
  return cost;
}

// Recordings without coordinates of the world all begin at 0: the site's prediction decides whether
// a case of the model that lies there is its own.
bool is_of_case(const PredictedError& predicted, std::size_t site, const ErrorModel& model,
                std::size_t trained) {
  if (model.sites[trained].has_label == 0) return false;
  for (std::size_t range = 0; range < predicted.looks.size(); ++range) {
    if (model.out_of_fold.mean(trained, range) != predicted.mean(site, range)) return false;
  }
  return true;
}

// Over all sites at one range.
double sum_of_errors_m(const OwnEvidence& evidence, std::size_t range) {
  std::vector<double> errors_m;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    errors_m.push_back(evidence.error_m[evidence.shape().index(site, range)]);
  }
  return ordered_sum(errors_m);
}

}  // namespace

Result<OwnEvidence> own_evidence_of(const FactorTable& factors) {
  std::optional<std::size_t> column;
  for (const char* name : {"own_error", "mapping_error", "virtual_error"}) {
    if (!column) column = column_of(factors, name);
  }
  if (!column) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the factors have neither own_error nor mapping_error nor virtual_error: nothing "
                 "is known of how well the map's own scans localize"};
  }
  return OwnEvidence{factors.looks, factors.site_count, values_of(factors, *column),
                     cost_of(factors), is_simulated(factors)};
}

void add_measured(const Sites& sites, const PredictedError& predicted, const ErrorModel& model,
                  OwnEvidence& evidence) {
  constexpr double kSamePlace_m = 1e-3;
  std::vector<Eigen::Vector3d> places_m;
  for (const TrainedSite& site : model.sites) places_m.push_back(site.p_world_m);
  const PointGrid grid(places_m);
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    if (predicted.out_of_fold[site] == 0) continue;
    const Eigen::Vector3d p_world_m = sites.frame.origin_world_m + sites.sites[site].p_map_m;
    grid.visit_within(p_world_m, kSamePlace_m, [&](const NearPoint& near) {
      if (!is_of_case(predicted, site, model, near.index)) return;
      for (std::size_t range = 0; range < evidence.looks.size(); ++range) {
        double& error_m = evidence.error_m[evidence.shape().index(site, range)];
        error_m = std::max(error_m, model.measured(near.index, range));
      }
    });
  }
}

OwnEvidence for_another_localizer(OwnEvidence evidence) {
  const std::size_t range_count = evidence.looks.size();
  for (std::size_t i = 0; i < evidence.error_m.size(); ++i) {
    const bool is_longest = i % range_count == range_count - 1;
    evidence.error_m[i] = is_longest ? 0.0 : std::numeric_limits<double>::infinity();
  }
  return evidence;
}

Standing standing_of(const OwnEvidence& evidence, double limit_m,
                     const std::vector<std::uint8_t>& range_index) {
  std::vector<double> within;
  std::vector<double> costs;
  for (std::size_t site = 0; site < evidence.site_count; ++site) {
    const std::size_t i = evidence.shape().index(site, range_index[site]);
    within.push_back(evidence.error_m[i] <= limit_m ? 1.0 : 0.0);
    costs.push_back(evidence.cost[i]);
  }
  const double count = std::max<double>(1.0, evidence.site_count);
  return {ordered_sum(within) / count, ordered_sum(costs) / count};
}

StaticAnswer best_static(const OwnEvidence& evidence, double limit_m, double least_coverage) {
  std::vector<StaticAnswer> answers;
  double most = 0.0;
  for (std::size_t range = 0; range < evidence.looks.size(); ++range) {
    const auto index = static_cast<std::uint8_t>(range);
    const std::vector<std::uint8_t> everywhere(evidence.site_count, index);
    answers.push_back({index, standing_of(evidence, limit_m, everywhere)});
    most = std::max(most, answers.back().standing.coverage);
  }
  if (most <= 0.0) {
    return *std::ranges::min_element(answers, {}, [&](const StaticAnswer& a) {
      return sum_of_errors_m(evidence, a.range_index);
    });
  }
  const double enough = std::min(least_coverage, most) - kRounding;
  std::erase_if(answers, [&](const StaticAnswer& a) { return a.standing.coverage < enough; });
  return *std::ranges::min_element(answers, {},
                                   [](const StaticAnswer& a) { return a.standing.cost; });
}

}  // namespace sightline
