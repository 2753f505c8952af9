#pragma once

#include <algorithm>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/sites.h"
#include "formats/model/error_model.h"

// A model whose out-of-fold predictions and labels are written by hand, and the sites it belongs
// to.

namespace sightline {

// Per site and range: P(error <= 0.1 m), and the error that was measured, m.
struct HandmadeSite {
  std::vector<double> probability;
  std::vector<double> error_m;
};

// Ranges 10, 20, ... m; limits 0.1 m and, where every probability rises halfway to 1, 0.25 m.
// `block_count` blocks of equal length, measured by two drives in turn, each predicted by trees of
// the other; predicted mean: 0.2 (1 - probability) m. One tree.
inline ErrorModel handmade_model(const std::vector<HandmadeSite>& sites,
                                 std::uint32_t block_count) {
  ErrorModel model;
  model.card.feature_set = "all";
  model.card.places = {{"handmade",
                        {"by hand", "again"},
                        static_cast<double>(sites.size()),
                        block_count,
                        {{{"mapping", "by foot", sha256("by foot")},
                          {"localization", "by hand", sha256("by hand")},
                          {"evaluation", "again", sha256("again")}}}}};
  model.card.hold_out = "drives";
  model.card.tree_count = 1;
  model.card.least_leaf_rows = 1;
  model.card.feature_share = 1.0;
  model.card.block_m = 60.0;
  model.card.buffer_m = 25.0;
  model.card.block_count = block_count;
  model.card.fold_count = 2;
  const std::size_t range_count = sites.front().error_m.size();
  PredictedError& predicted = model.out_of_fold;
  predicted.limits_m = {0.1, 0.25};
  predicted.site_count = static_cast<std::uint32_t>(sites.size());
  predicted.extrapolated.assign(sites.size() * sites.front().error_m.size(), 0);
  predicted.out_of_fold.assign(sites.size(), 1);
  predicted.has_history.assign(sites.size(), 0);
  for (std::size_t range = 0; range < range_count; ++range) {
    predicted.looks.push_back(every_return(10.0 * static_cast<double>(range + 1)));
    model.ranges.push_back({predicted.looks.back().range_m, 0.0, 0.0, 0.0});
  }
  for (std::size_t i = 0; i < sites.size(); ++i) {
    TrainedSite site;
    site.p_world_m.x() = site.s_m = static_cast<double>(i);
    site.block = static_cast<std::uint32_t>(i * block_count / sites.size());
    site.drive = site.block % 2;
    site.has_label = 1;
    model.sites.push_back(site);
    for (std::size_t range = 0; range < range_count; ++range) {
      const double probability = sites[i].probability[range];
      predicted.mean_m.push_back(0.2 * (1.0 - probability));
      predicted.within_probability.push_back(probability);
      predicted.within_probability.push_back(0.5 + 0.5 * probability);
      model.measured_mean_m.push_back(sites[i].error_m[range]);
    }
  }
  model.forest.feature_count = 1;
  model.forest.labels = model.measured_mean_m;
  std::sort(model.forest.labels.begin(), model.forest.labels.end());
  model.forest.rows.assign(model.forest.labels.size(), 0.0F);
  const std::vector<double> spread(range_count, 0.0);
  model.features = {{"range_m", 0.0, spread, spread}};
  model.forest.trees.resize(1);
  return model;
}

inline Sites sites_of(const ErrorModel& model) {
  Sites sites;
  for (const TrainedSite& trained : model.sites) {
    Site site;
    site.run = trained.run;
    site.s_m = trained.s_m;
    site.p_map_m = trained.p_world_m;
    sites.sites.push_back(site);
  }
  return sites;
}

// Factors that tell of the map's own scans alone: `own_error_m` [site][range].
inline FactorTable factors_with_own_error(const std::vector<double>& ranges_m,
                                          const std::vector<std::vector<double>>& own_error_m) {
  FactorTable factors;
  factors.looks = every_return_at(ranges_m);
  factors.factors = {"own_error", "virtual_points"};
  factors.site_count = static_cast<std::uint32_t>(own_error_m.size());
  for (const std::vector<double>& site : own_error_m) {
    for (std::size_t range = 0; range < ranges_m.size(); ++range) {
      factors.values.insert(factors.values.end(), {site[range], 20.0 * ranges_m[range]});
    }
  }
  return factors;
}

// Own scans that ask for the longest range everywhere: no choice is dearer.
inline FactorTable demanding_factors(const ErrorModel& model) {
  std::vector<double> site(model.ranges.size(), 1.0);
  site.back() = 0.0;
  return factors_with_own_error(ranges_of(model.out_of_fold.looks),
                                std::vector<std::vector<double>>(model.sites.size(), site));
}

}  // namespace sightline
