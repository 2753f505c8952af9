#include "passes/learn/out_of_fold.h"

#include <cmath>
#include <numeric>
#include <utility>

#include "compiler/base/parallel.h"
#include "compiler/base/random.h"
#include "passes/learn/forest_prediction.h"

namespace sightline {
namespace {

// Keys of the random streams of a fold; the forest over everything takes key 0.
constexpr std::uint64_t kFoldKey = 1;
constexpr std::uint64_t kShuffleKey = std::uint64_t{1} << 32;

std::vector<std::uint32_t> rows_of_fold(const Lesson& lesson, std::uint32_t fold) {
  std::vector<std::uint32_t> rows;
  for (std::size_t site = 0; site < lesson.has_label.size(); ++site) {
    if (lesson.folds.fold_of_site(site) != fold) continue;
    for (std::size_t range = 0; range < lesson.range_count; ++range) {
      rows.push_back(static_cast<std::uint32_t>(site * lesson.range_count + range));
    }
  }
  return rows;
}

double squared_error(const Lesson& lesson, const std::vector<std::uint32_t>& rows,
                     const std::vector<double>& mean) {
  std::vector<double> squares(rows.size(), 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (lesson.has_label[rows[i] / lesson.range_count] == 0) continue;
    const double residual = mean[i] - lesson.labels[rows[i]];
    squares[i] = residual * residual;
  }
  return ordered_sum(squares);
}

// Squared error of the fold's rows after they swapped their values of one feature.
double shuffled_squared_error(const Lesson& lesson, const PreparedForest& forest,
                              const std::vector<std::uint32_t>& rows, std::size_t feature,
                              std::uint64_t seed) {
  FeatureRows shuffled;
  shuffled.names = lesson.features.names;
  shuffled.row_count = rows.size();
  for (const std::uint32_t row : rows) {
    const float* values = lesson.features.row(row);
    shuffled.values.insert(shuffled.values.end(), values, values + shuffled.names.size());
  }
  Random random(seed);
  for (std::size_t i = rows.size(); i > 1; --i) {
    std::swap(shuffled.at(i - 1, feature), shuffled.at(random.below(i), feature));
  }
  std::vector<std::uint32_t> order(rows.size());
  std::iota(order.begin(), order.end(), 0U);
  return squared_error(lesson, rows, forest.predict(shuffled, order, 1).mean);
}

void store(const std::vector<std::uint32_t>& rows, const ForestPrediction& prediction,
           PredictedError& predicted) {
  const std::size_t limit_count = predicted.limits_m.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    predicted.mean_m[rows[i]] = prediction.mean[i];
    for (std::size_t limit = 0; limit < limit_count; ++limit) {
      predicted.within_probability[rows[i] * limit_count + limit] =
          prediction.within[i * limit_count + limit];
    }
  }
}

// Sums over folds of squared errors: [0] as predicted, [1 + f] with feature f shuffled.
using SquaredErrors = std::vector<double>;

void predict_fold(const PassContext& ctx, const Lesson& lesson, const RegressionForest& forest,
                  std::uint32_t fold, std::pair<PredictedError&, SquaredErrors&> out) {
  const PreparedForest prepared(forest, out.first.limits_m);
  const std::vector<std::uint32_t> rows = rows_of_fold(lesson, fold);
  const ForestPrediction prediction = prepared.predict(lesson.features, rows, ctx.threads);
  store(rows, prediction, out.first);
  out.second[0] += squared_error(lesson, rows, prediction.mean);
  const std::size_t feature_count = lesson.features.names.size();
  const std::vector<double> shuffled =
      parallel_map<double>(feature_count, ctx.threads, [&](std::size_t feature) {
        const std::uint64_t key = kShuffleKey + fold * feature_count + feature;
        return shuffled_squared_error(lesson, prepared, rows, feature, mix(ctx.seed, key));
      });
  for (std::size_t i = 0; i < feature_count; ++i) out.second[1 + i] += shuffled[i];
}

std::vector<double> rmse_rises(const SquaredErrors& errors, std::size_t row_count) {
  const auto rmse = [&](double sum) { return std::sqrt(sum / static_cast<double>(row_count)); };
  std::vector<double> rises;
  for (std::size_t i = 1; i < errors.size(); ++i)
    rises.push_back(rmse(errors[i]) - rmse(errors[0]));
  return rises;
}

PredictedError sized_for(const Sites& sites, PredictedError predicted) {
  const std::size_t site_count = sites.sites.size();
  const std::size_t pairs = site_count * predicted.ranges_m.size();
  predicted.site_count = static_cast<std::uint32_t>(site_count);
  predicted.mean_m.assign(pairs, 0.0);
  predicted.within_probability.assign(pairs * predicted.limits_m.size(), 0.0);
  predicted.extrapolated.assign(site_count, 0);
  predicted.out_of_fold.assign(site_count, 1);
  return predicted;
}

}  // namespace

TrainingSet labelled_rows(const Lesson& lesson, const std::vector<std::uint8_t>& leave_out) {
  TrainingSet training;
  for (std::size_t site = 0; site < lesson.has_label.size(); ++site) {
    if (lesson.has_label[site] == 0 || leave_out[site] != 0) continue;
    for (std::size_t range = 0; range < lesson.range_count; ++range) {
      const std::size_t row = site * lesson.range_count + range;
      training.rows.push_back(static_cast<std::uint32_t>(row));
      training.labels.push_back(lesson.labels[row]);
    }
  }
  return training;
}

Result<OutOfFold> predict_out_of_fold(const PassContext& ctx, const OutOfFoldOptions& options,
                                      const Sites& sites, const Lesson& lesson,
                                      PredictedError predicted) {
  OutOfFold result{sized_for(sites, std::move(predicted)), {}};
  SquaredErrors errors(1 + lesson.features.names.size(), 0.0);
  for (std::uint32_t fold = 0; fold < lesson.folds.fold_count; ++fold) {
    const TrainingSet training =
        labelled_rows(lesson, sites_near_fold(sites, lesson.folds, fold, options.buffer_m));
    if (training.rows.empty()) {
      return Error{ErrorCode::kDriveTooShort,
                   "a buffer of " + format_double(options.buffer_m) +
                       " m around held-out blocks leaves nothing to learn from in " +
                       format_double(lesson.folds.labelled_route_m) +
                       " m of route; a longer drive is needed",
                   "", "fold " + std::to_string(fold)};
    }
    const Result<RegressionForest> forest = grow_forest(
        lesson.features, training, options.forest, mix(ctx.seed, kFoldKey + fold), ctx.threads);
    if (!forest) return forest.error();
    predict_fold(ctx, lesson, *forest, fold, {result.predicted, errors});
    ctx.progress(fold + 1, lesson.folds.fold_count + 1);
  }
  const TrainingSet all =
      labelled_rows(lesson, std::vector<std::uint8_t>(lesson.has_label.size(), 0));
  result.importance = rmse_rises(errors, all.rows.size());
  return result;
}

}  // namespace sightline
