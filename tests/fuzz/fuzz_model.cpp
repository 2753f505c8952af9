// An error model from a file or a section of a map: refused, or valid and fit to predict.

#include <algorithm>

#include "formats/base/check.h"
#include "formats/model/error_model.h"
#include "passes/model/forest/forest_prediction.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

using Traits = ArtifactTraits<ErrorModel>;

void predict(const ErrorModel& model) {
  FeatureRows rows;
  rows.row_count = 2;
  for (const FeatureCard& feature : model.features) rows.names.push_back(feature.name);
  rows.values.assign(rows.row_count * rows.names.size(), 12.0F);
  std::fill(rows.values.begin(), rows.values.begin() + static_cast<long>(rows.names.size()), -1.0F);
  const PreparedForest forest(model.forest, {0.1, 0.25}, 1);
  for (const double share : forest.predict(rows, {0, 1}, 1).within) {
    SIGHTLINE_CHECK(share >= 0.0 && share <= 1.0 + 1e-9);
  }
}

void use(const ByFamily<ErrorModel>& model) {
  predict(model.ranges);
  SIGHTLINE_CHECK(!to_text(model).empty());
  SIGHTLINE_CHECK(!dump(model).columns.empty());
  SIGHTLINE_CHECK(!tables(model.ranges).empty());
  const auto back = from_bytes<ByFamily<ErrorModel>>(to_bytes(model));
  SIGHTLINE_CHECK(back.has_value());
  SIGHTLINE_CHECK(to_bytes(*back) == to_bytes(model));
}

}  // namespace
}  // namespace sightline

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  using namespace sightline;
  const auto sealed = std::as_bytes(std::span(data, size));
  const Result<std::span<const std::byte>> unsealed =
      unseal(sealed, Traits::kName, Traits::kVersion);
  if (!unsealed || seed % 16 == 0) return LLVMFuzzerMutate(data, size, max_size);
  std::vector<std::byte> payload(unsealed->begin(), unsealed->end());
  const std::size_t old_size = payload.size();
  payload.resize(old_size + 64);
  const std::size_t new_size =
      LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(payload.data()), old_size, payload.size());
  payload.resize(new_size);
  return hand_back(seal(Traits::kName, Traits::kVersion, std::move(payload)), data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const FuzzInput input(data, size);
  const auto model = from_bytes<ByFamily<ErrorModel>>(input.bytes());
  if (model) use(*model);
  return 0;
}
