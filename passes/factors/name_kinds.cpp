#include "passes/factors/name_kinds.h"

#include "formats/model/place_kind.h"

namespace sightline {

Result<SiteColumn> name_kinds(PassContext& /*ctx*/, const NoOptions& /*options*/,
                              const Sites& sites, const StoredTable<FactorTable>& factors) {
  if (factors.row_count() != sites.sites.size()) {
    return Error{
        ErrorCode::kMismatchedInputs,
        concat("found factors of ", factors.row_count(), " sites, expected ", sites.sites.size()),
        "", "pass name-kinds"};
  }
  SIGHTLINE_ASSIGN(const std::vector<PlaceKind> kinds, place_kinds(sites, factors));
  SiteColumn column{std::string(kPlaceKindColumn), "", {}};
  for (std::size_t kind = 0; kind < kPlaceKindCount; ++kind) {
    column.steps.push_back(static_cast<float>(kind));
  }
  for (const PlaceKind kind : kinds) column.values.push_back(static_cast<float>(kind));
  return column;
}

}  // namespace sightline
