#include "compiler/driver/model_source.h"

#include <system_error>

#include "compiler/driver/provide_inputs.h"
#include "passes/emit/emit_map.h"
#include "passes/localize/measure_error.h"
#include "passes/map/build_ndt.h"

namespace sightline {
namespace {

bool is_small(const CompileConfig& config) {
  return config.passes.options(kEmitMap).size == MapSize::kPromise;
}

LocalizerProfile localizer_of(const CompileConfig& config) {
  MeasureErrorOptions measuring = config.passes.options(kMeasureError);
  measuring.in_small_map = is_small(config);
  return matching_card(measuring, config.passes.options(kBuildNdt).cell_m).localizer;
}

std::vector<Look> ranges_of(const CompileConfig& config) {
  std::vector<Look> ranges;
  for (const double range_m : config.annotation.ranges_m) ranges.push_back(every_return(range_m));
  return ranges;
}

// What differs between the errors that a model predicts and those of this compile; empty: nothing.
std::string difference(const CompileConfig& config, const ByFamily<ErrorModel>& model) {
  const PredictedError& known = model.ranges.out_of_fold;
  if (known.looks != ranges_of(config)) return "other ranges";
  if (!model.samples || model.samples->out_of_fold.looks != config.annotation.looks)
    return "other looks";
  if (known.limits_m != config.annotation.limits_m) return "other limits";
  if (is_small(config) != was_in_small_map(model.ranges.card.localizer)) return "full maps";
  const bool is_own =
      !config.imports_errors() && model.ranges.card.localizer == localizer_of(config);
  return is_own ? "" : "another localizer";
}

}  // namespace

std::filesystem::path shipped_model(const std::filesystem::path& program) {
  return program.parent_path().parent_path() / "share/sightline/models/generated.slmodel";
}

std::filesystem::path shipped_model() {
  std::error_code failure;
  return shipped_model(std::filesystem::read_symlink("/proc/self/exe", failure));
}

Result<ChosenModel> choose_model(const CompileConfig& config, const std::filesystem::path& given,
                                 const std::filesystem::path& shipped) {
  if (!given.empty()) return ChosenModel{given, ""};
  const bool is_shipped = config.annotation.model == DefaultModel::kGenerated && !config.has_map();
  if (!is_shipped) return ChosenModel{};
  std::error_code failure;
  if (!std::filesystem::exists(shipped, failure)) {
    return Error{ErrorCode::kFileNotFound,
                 "the error model that comes with the program is missing: install the program "
                 "again, or set annotation.model=own",
                 shipped.string()};
  }
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, read_model(shipped));
  const std::string other = difference(config, model);
  if (other.empty()) return ChosenModel{shipped, ""};
  return ChosenModel{"", concat("the error model that comes with the program is of ", other,
                                ": a model is trained on the drives of this compile")};
}

}  // namespace sightline
