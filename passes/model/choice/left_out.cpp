#include "passes/model/choice/left_out.h"

#include <utility>

#include "formats/annotation/measured_drives.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"

namespace sightline {

Result<std::vector<LeftOutDrive>> leave_out_in_turn(const PassContext& ctx, const ErrorModel& model,
                                                    const Sites& sites, const FactorTable& factors,
                                                    double support_margin) {
  std::vector<LeftOutDrive> left_out;
  std::vector<MeasuredError> drives = measured_of_columns(factors);
  if (drives.size() < 2 || !model.card.knows_history) return left_out;
  // Columns are kept of drives by the model's localizer alone (predict_error).
  for (MeasuredError& drive : drives) drive.matching.localizer = model.card.localizer;
  const std::vector<bool> is_independent = independence_of_columns(factors);
  PassContext quiet;  // warnings were given when all drives were used
  quiet.threads = ctx.threads;
  quiet.seed = ctx.seed;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (!is_independent[i]) continue;
    MeasuredDrives others;
    for (std::size_t other = 0; other < drives.size(); ++other) {
      if (other != i) others.drives.push_back(drives[other]);
    }
    SIGHTLINE_ASSIGN(PredictedError predicted,
                     predict_error(quiet, {.support_margin = support_margin}, model, sites, factors,
                                   {}, nullptr, &others));
    left_out.push_back({std::move(predicted), drives[i]});
  }
  return left_out;
}

std::vector<LeftOutDrive> samples_of(const std::vector<LeftOutDrive>& drives) {
  std::vector<LeftOutDrive> samples;
  for (const LeftOutDrive& drive : drives) {
    if (drive.predicted.of_samples.empty() || drive.measured.of_samples.empty()) return {};
    samples.push_back({drive.predicted.of_samples.front(), drive.measured.of_samples.front()});
  }
  return samples;
}

}  // namespace sightline
