#pragma once

#include "formats/drive/drive.h"
#include "formats/drive/recording_cards.h"
#include "passes/pass/pass.h"

namespace sightline {

// The cards of recordings with a sketch of each scan that ingest() kept ("Identity of recordings"
// in schemas/definitions.md), so that copies are recognized. `drives` are those of the first cards
// that are of no finished map and no released poses; the scans of other cards stay unknown. Warns
// of recordings that have scans in common. Errors: bad-value where more than half of a recording's
// scans are copies of scans of an earlier one; mismatched-inputs where there are more drives than
// cards; those of the scan stores.
Result<RecordingCards> identify_recordings(PassContext& ctx, const NoOptions& options,
                                           const RecordingCards& recordings, Many<Drive> drives);
inline constexpr Pass kIdentifyRecordings = Pass{"identify-recordings", 1, "identified-recordings",
                                                 "Identity of recordings", &identify_recordings}
                                                .in(Stage::kGraph)
                                                .with({.scan_s = 0.002});

}  // namespace sightline
