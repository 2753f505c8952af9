#include "passes/model/forest/out_of_fold.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "passes/model/forest/forest_prediction.h"

namespace sightline {
namespace {

// Keys of the random streams of a fold; the forest over everything takes key 0.
constexpr std::uint64_t kFoldKey = 1;
constexpr std::uint64_t kShuffleKey = std::uint64_t{1} << 32;

// What one forest predicts: a fold, or of a fold what one drive measured.
struct Part {
  std::uint32_t fold = 0;
  std::optional<std::uint32_t> drive;
};

std::vector<Part> parts_of(const TrainingSet& training_set) {
  std::vector<Part> parts;
  for (std::uint32_t fold = 0; fold < training_set.folds.fold_count; ++fold) {
    if (training_set.held_out != HoldOut::kDrives) {
      parts.push_back({fold, std::nullopt});
      continue;
    }
    for (std::uint32_t drive = 0; drive < training_set.drive_count; ++drive) {
      parts.push_back({fold, drive});
    }
  }
  return parts;
}

bool is_drive_of(const Part& part, const TrainingSet& training_set, std::size_t site) {
  return !part.drive || training_set.drive_of_site[site] == *part.drive;
}

// 1 for the sites that the trees of a part must not learn from.
std::vector<std::uint8_t> left_out_of(const TrainingSet& training_set, const Part& part,
                                      double buffer_m) {
  std::vector<std::uint8_t> left_out =
      sites_near_fold(training_set.sites, training_set.folds, part.fold, buffer_m);
  for (std::size_t site = 0; part.drive && site < left_out.size(); ++site) {
    if (is_drive_of(part, training_set, site)) left_out[site] = 1;
  }
  return left_out;
}

std::vector<std::uint32_t> rows_of_part(const TrainingSet& training_set, const Part& part) {
  std::vector<std::uint32_t> rows;
  for (std::size_t site = 0; site < training_set.sites.size(); ++site) {
    if (training_set.folds.fold_of_block[training_set.sites[site].block] != part.fold) continue;
    if (!is_drive_of(part, training_set, site)) continue;
    for (std::size_t range = 0; range < training_set.range_count; ++range) {
      rows.push_back(static_cast<std::uint32_t>(training_set.shape().index(site, range)));
    }
  }
  return rows;
}

double squared_error(const TrainingSet& training_set, const std::vector<std::uint32_t>& rows,
                     const std::vector<double>& mean) {
  std::vector<double> squares(rows.size(), 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (training_set.sites[training_set.shape().site_of(rows[i])].has_label == 0) continue;
    const double residual = mean[i] - training_set.labels[rows[i]];
    squares[i] = residual * residual;
  }
  return ordered_sum(squares);
}

// Rows enough to tell how much a feature matters; more would only take longer.
constexpr std::size_t kImportanceRows = 20000;

// Every second, third, ... of the rows where they are too many.
std::vector<std::uint32_t> thinned(const std::vector<std::uint32_t>& rows, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, (rows.size() + most - 1) / most);
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < rows.size(); i += stride) kept.push_back(rows[i]);
  return kept;
}

// [row][feature]: the values of some rows after they swapped those of each feature, feature by
// feature. `seeds`: one each.
std::vector<float> shuffled_values(const FeatureRows& features,
                                   const std::vector<std::uint32_t>& rows,
                                   const std::vector<std::uint64_t>& seeds) {
  const std::size_t feature_count = features.names.size();
  std::vector<float> shuffled;
  for (const std::uint32_t row : rows) {
    shuffled.insert(shuffled.end(), features.row(row), features.row(row) + feature_count);
  }
  for (std::size_t feature = 0; feature < feature_count; ++feature) {
    Random random(seeds[feature]);
    const auto value = [&](std::size_t i) -> float& {
      return shuffled[i * feature_count + feature];
    };
    for (std::size_t i = rows.size(); i > 1; --i) std::swap(value(i - 1), value(random.below(i)));
  }
  return shuffled;
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

// What the parts add to.
struct FoldSums {
  PredictedError& predicted;
  std::vector<double> squares;   // of errors: [0] as predicted, [1 + f] with feature f shuffled
  std::size_t judged_count = 0;  // rows in those sums
};

std::size_t labelled_count(const TrainingSet& training_set,
                           const std::vector<std::uint32_t>& rows) {
  return static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [&](std::uint32_t row) {
    return training_set.sites[training_set.shape().site_of(row)].has_label == 1;
  }));
}

// A part's rows, and what shuffles them.
struct PartRows {
  std::vector<std::uint32_t> rows;
  std::size_t number = 0;  // of the part
  std::size_t part_count = 0;
};

void predict_part(const PassContext& ctx, const TrainingSet& training_set,
                  const PreparedForest& forest, const PartRows& part, FoldSums& out) {
  store(part.rows, forest.predict(training_set.features, part.rows, ctx.threads), out.predicted);
  const std::vector<std::uint32_t> judged =
      thinned(part.rows, kImportanceRows / part.part_count + 1);
  std::vector<double> means;
  for (const std::uint32_t row : judged) means.push_back(out.predicted.mean_m[row]);
  out.squares[0] += squared_error(training_set, judged, means);
  const std::size_t feature_count = training_set.features.names.size();
  std::vector<std::uint64_t> seeds;
  for (std::size_t feature = 0; feature < feature_count; ++feature) {
    seeds.push_back(mix(ctx.seed, kShuffleKey + part.number * feature_count + feature));
  }
  const std::vector<double> shuffled =
      forest.means_with_others(training_set.features, judged,
                               shuffled_values(training_set.features, judged, seeds), ctx.threads);
  for (std::size_t feature = 0; feature < feature_count; ++feature) {
    for (std::size_t i = 0; i < judged.size(); ++i)
      means[i] = shuffled[i * feature_count + feature];
    out.squares[1 + feature] += squared_error(training_set, judged, means);
  }
  out.judged_count += labelled_count(training_set, judged);
}

std::vector<double> rmse_rises(const FoldSums& sums) {
  const auto row_count = static_cast<double>(std::max<std::size_t>(1, sums.judged_count));
  const auto rmse = [&](double sum) { return std::sqrt(sum / row_count); };
  std::vector<double> rises;
  for (std::size_t i = 1; i < sums.squares.size(); ++i) {
    rises.push_back(rmse(sums.squares[i]) - rmse(sums.squares[0]));
  }
  return rises;
}

// The same trees; their leaves have the labels from tracking starts.
LabelledTrees with_tracking_labels(const TrainingSet& training_set, LabelledTrees trees) {
  const std::size_t feature_count = training_set.features.names.size();
  const float* const first = training_set.features.values.data();
  for (std::size_t i = 0; i < trees.rows.size(); ++i) {
    const std::size_t row = static_cast<std::size_t>(trees.rows[i] - first) / feature_count;
    trees.labels[i] = double{training_set.tracking_labels_m[row]};
  }
  return trees;
}

// Sets the shares of a part's rows.
void predict_tracking(const PassContext& ctx, const TrainingSet& training_set,
                      const LabelledTrees& trees, const std::vector<std::uint32_t>& rows,
                      OutOfFold& out) {
  if (training_set.tracking_labels_m.empty()) return;
  const std::vector<double>& limits_m = out.predicted.limits_m;
  out.tracking.mean.resize(out.predicted.mean_m.size(), 0.0);
  out.tracking.within.resize(out.predicted.within_probability.size(), 0.0);
  const PreparedForest forest(with_tracking_labels(training_set, trees), limits_m, ctx.threads);
  const ForestPrediction found = forest.predict(training_set.features, rows, ctx.threads);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out.tracking.mean[rows[i]] = found.mean[i];
    for (std::size_t limit = 0; limit < limits_m.size(); ++limit) {
      out.tracking.within[rows[i] * limits_m.size() + limit] =
          found.within[i * limits_m.size() + limit];
    }
  }
}

PredictedError sized_for(const std::vector<TrainedSite>& sites, PredictedError predicted) {
  const std::size_t site_count = sites.size();
  predicted.site_count = static_cast<std::uint32_t>(site_count);
  predicted.mean_m.assign(predicted.mean_shape().size(site_count), 0.0);
  predicted.within_probability.assign(predicted.probability_shape().size(site_count), 0.0);
  predicted.extrapolated.assign(predicted.mean_m.size(), 0);
  predicted.out_of_fold.assign(site_count, 1);
  for (const TrainedSite& site : sites) predicted.has_history.push_back(site.has_history);
  return predicted;
}

}  // namespace

Result<OutOfFold> predict_out_of_fold(const PassContext& ctx, const OutOfFoldOptions& options,
                                      const TrainingSet& training_set, PredictedError predicted) {
  OutOfFold result{sized_for(training_set.sites, std::move(predicted)), {}};
  FoldSums sums{result.predicted, std::vector<double>(1 + training_set.features.names.size(), 0.0)};
  const std::vector<Part> parts = parts_of(training_set);
  for (std::size_t number = 0; number < parts.size(); ++number) {
    const Part& part = parts[number];
    PartRows rows{rows_of_part(training_set, part), number, parts.size()};
    if (rows.rows.empty()) continue;  // this drive was never there
    const LabelledRows training = labelled_rows(
        training_set, left_out_of(training_set, part, options.buffer_m), options.most_rows);
    if (training.rows.empty()) {
      return Error{ErrorCode::kDriveTooShort,
                   concat("a buffer of ", format_double(options.buffer_m),
                          " m around held-out blocks leaves no training data in ",
                          format_double(training_set.folds.labelled_route_m),
                          " m of route: record a longer drive, or lower train-model.buffer_m"),
                   "", concat("fold ", part.fold)};
    }
    SIGHTLINE_ASSIGN(LabelledTrees trees,
                     grow_labelled_trees(training_set.features, training, options.forest,
                                         mix(ctx.seed, kFoldKey + number), ctx.threads));
    predict_tracking(ctx, training_set, trees, rows.rows, result);
    const PreparedForest forest(std::move(trees), result.predicted.limits_m, ctx.threads);
    predict_part(ctx, training_set, forest, rows, sums);
    ctx.progress(number + 1, parts.size() + 1);
  }
  result.importance = rmse_rises(sums);
  return result;
}

}  // namespace sightline
