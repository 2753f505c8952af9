#pragma once

#include "formats/annotation/driven_places.h"
#include "passes/model/train_model.h"
#include "tests/support/whole_rows.h"

namespace sightline {

// A model of one place that was driven once.
inline Result<ErrorModel> train_on_place(PassContext& ctx, const TrainModelOptions& options,
                                         const DrivenPlace& place) {
  return of_ranges(train_model_here(ctx, options, place.sites, place.factors, place.drives.front(),
                                    place.recordings));
}

}  // namespace sightline
