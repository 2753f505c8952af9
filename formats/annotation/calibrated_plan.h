#pragma once

#include <cstdint>
#include <optional>

#include "formats/artifact.h"
#include "formats/drive/look.h"
#include "formats/record/fields.h"

namespace sightline {

// The plan of a map, and how it was set ("Driving by a plan" in schemas/definitions.md).
struct CalibratedPlan {
  std::optional<LookPlan> plan;  // none where the map has no looks that take a sample
  // Of the scans that it was tried on: how many there were, how many first looks were good, and
  // which shares of these the learnt threshold doubts, and that of the plan.
  std::uint32_t scan_count = 0;
  std::uint32_t good_count = 0;
  double learnt_doubted_share = 0.0;
  double doubted_share = 0.0;
};
SIGHTLINE_FIELDS(CalibratedPlan, plan, scan_count, good_count, learnt_doubted_share, doubted_share)
SIGHTLINE_ARTIFACT(CalibratedPlan, "calibrated-plan", 2)

Result<void> validate(const CalibratedPlan& calibrated);
Table dump(const CalibratedPlan& calibrated);

}  // namespace sightline
