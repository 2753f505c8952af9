#pragma once

#include "formats/annotation/factor_table.h"
#include "formats/annotation/site_column.h"
#include "formats/annotation/sites.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/pass.h"

namespace sightline {

// The kind of place of each site, as the column kPlaceKindColumn: its number in PlaceKind
// (formats/model/place_kind.h). Errors: mismatched-inputs (factors of other sites), cannot-read.
Result<SiteColumn> name_kinds(PassContext& ctx, const NoOptions& options, const Sites& sites,
                              const StoredTable<FactorTable>& factors);
inline constexpr Pass kNameKinds =
    Pass{"name-kinds", 1, "kinds", "Kinds of places along the route", &name_kinds}.in(
        Stage::kLearn);

}  // namespace sightline
