#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/by_family.h"
#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/grid/site_shape.h"
#include "formats/record/fields.h"

namespace sightline {

// What the error model says of every site at every look of a family.
struct PredictedError {
  std::vector<Look> looks;       // from the cheapest to the dearest
  std::vector<double> limits_m;  // ascending
  std::uint32_t site_count = 0;
  std::vector<double> mean_m;              // [site][look]: predicted mean error
  std::vector<double> within_probability;  // [site][look][limit]: P(error <= limit)
  // [site][look]: 1 where what the forest decides by lies outside what the model saw.
  std::vector<std::uint8_t> extrapolated;
  // [site]: 1 where the model was trained on this site, and trees that never saw the place speak.
  std::vector<std::uint8_t> out_of_fold;
  // [site]: 1 where errors that an earlier drive measured near it were among the features.
  std::vector<std::uint8_t> has_history;
  double support_margin = 0.25;  // by which `extrapolated` was judged (PredictErrorOptions)

  [[nodiscard]] SiteShape mean_shape() const { return {looks.size()}; }
  [[nodiscard]] SiteShape probability_shape() const { return {looks.size(), limits_m.size()}; }

  [[nodiscard]] double mean(std::size_t site, std::size_t range) const {
    return mean_m[mean_shape().index(site, range)];
  }
  [[nodiscard]] bool is_extrapolated(std::size_t site, std::size_t range) const {
    return extrapolated[mean_shape().index(site, range)] == 1;
  }
  [[nodiscard]] double probability(std::size_t site, std::size_t range, std::size_t limit) const {
    return within_probability[probability_shape().index(site, range, limit)];
  }
};
SIGHTLINE_FIELDS(PredictedError, looks, limits_m, site_count, mean_m, within_probability,
                 extrapolated, out_of_fold, has_history, support_margin)

template <>
struct ArtifactTraits<PredictedError> {
  static constexpr std::string_view kName = "predicted-error";
  static constexpr std::uint32_t kVersion = 7;
};

Result<void> validate(const PredictedError& predicted);
Table dump(const PredictedError& predicted);

// The predictions without support_margin, as a model keeps its own.
void encode_predictions(const PredictedError& predicted, ByteWriter& writer);
void decode_predictions(ByteReader& reader, PredictedError& predicted);

}  // namespace sightline
